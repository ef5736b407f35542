#include "validate/camera/photographer_pool.h"

namespace backbend::validate {

PhotographerPool::PhotographerPool(const Stage& stage, const render::Bounds& box)
    : stage_(stage), box_(box), facing_(facing_of(stage.anatomy())), topology_(stage.topology()) {}

PhotographerPool::Loan::Loan(PhotographerPool& pool) : pool_(pool) {
  {
    const std::lock_guard lock(pool_.mutex_);
    if (!pool_.idle_.empty()) {
      photographer_ = std::move(pool_.idle_.back());
      pool_.idle_.pop_back();
    }
  }
  if (!photographer_)
    photographer_ = std::make_unique<Photographer>(pool_.stage_, pool_.box_, pool_.topology_);
}

PhotographerPool::Loan::~Loan() {
  const std::lock_guard lock(pool_.mutex_);
  pool_.idle_.push_back(std::move(photographer_));
}

}  // namespace backbend::validate
