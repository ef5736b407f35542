#pragma once
#include <filesystem>
#include <string>

#include "validate/prove/proof.h"

namespace backbend::validate {

/// What a certificate file says: the question, and the tree of boxes with what is claimed of each.
struct Certificate {
  ProofQuestion question;
  ProofTree tree;
};

/// One JSON object, schema `backbend.certificate/1`. The tree is one string, the whole box first: a
/// digit splits a box at the middle of that axis (its lower half follows, then its upper), a, b or
/// c does so for axis 0, 1 or 2 without a look before, another letter is a BoxState. Refutations
/// stand in the order of their boxes. The last key is a hash of the rest.
std::string certificate_text(const Certificate& certificate);

/// Throws ProofError, after `name`, for a text that is cut, changed, of another schema or not a
/// certificate.
Certificate parse_certificate(const std::string& text, const std::string& name);

/// Throws ReadError too.
Certificate read_certificate(const std::filesystem::path& file);
/// Appears whole or not at all. Throws WriteError.
void write_certificate(const std::filesystem::path& file, const Certificate& certificate);

/// Why a certificate answers another question; empty: the same.
std::string difference(const ProofQuestion& a, const ProofQuestion& b);

}  // namespace backbend::validate
