#pragma once
#include <memory>
#include <mutex>
#include <vector>

#include "validate/camera/photographer.h"

namespace backbend::validate {

/// Photographers of one character, for pieces of work that take pictures of different poses at the
/// same time. There are as many as were ever in use at once: one a thread.
class PhotographerPool {
 public:
  /// `box` holds every pose that is to be compared. `stage` must outlive the pool.
  PhotographerPool(const Stage& stage, const render::Bounds& box);

  /// One photographer, for as long as this lives.
  class Loan {
   public:
    explicit Loan(PhotographerPool& pool);
    ~Loan();
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    Photographer& operator*() const { return *photographer_; }
    Photographer* operator->() const { return photographer_.get(); }

   private:
    PhotographerPool& pool_;
    std::unique_ptr<Photographer> photographer_;
  };

  const Stage& stage() const { return stage_; }
  const render::Bounds& box() const { return box_; }
  const render::Facing& facing() const { return facing_; }

 private:
  const Stage& stage_;
  render::Bounds box_;
  render::Facing facing_;
  std::shared_ptr<const render::MeshTopology> topology_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Photographer>> idle_;
};

}  // namespace backbend::validate
