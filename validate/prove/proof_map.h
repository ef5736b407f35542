#pragma once
#include <string>
#include <vector>

#include "validate/prove/proof_box.h"
#include "validate/text/terminal_style.h"

namespace backbend::validate {

/// What became of a box, as letters: bands of its last axis that varies, each a picture of the
/// first two. A cell has the worst of the parts that it meets.
class ProofMap {
 public:
  static constexpr char kCertified = '+', kOpen = '?', kRefuted = 'x';
  struct Band {
    double low, high;
    std::vector<std::string> row;  // by falling side; letters by rising extension
  };

  /// Everywhere certified. Keeps a reference to the box.
  ProofMap(const ProofBox& box, std::size_t columns);
  void mark(const SubBox& part, char state);

  const std::vector<Band>& bands() const { return band_; }
  std::size_t up() const { return up_; }  // axes; they may be fixed ones
  std::size_t along() const { return along_; }

 private:
  const ProofBox& box_;
  std::size_t columns_, rows_, up_, along_;
  std::vector<Band> band_;
};

/// As many columns as a terminal has room for.
std::size_t map_columns(const TerminalStyle& style);
/// The map with its legend.
std::string map_text(const ProofMap& map, const ProofBox& box, const TerminalStyle& style);

/// A share as people read it: never 100 % or 0 % where it is not.
std::string share_text(double share);

}  // namespace backbend::validate
