#include "validate/verdicts/names.h"

#include <array>
#include <utility>

namespace backbend::validate {
namespace {

template <class E>
using Word = std::pair<E, std::string_view>;

constexpr std::array<Word<Verdict>, 6> kVerdicts{{{Verdict::pass, "pass"},
                                                  {Verdict::fail, "fail"},
                                                  {Verdict::waived, "waived"},
                                                  {Verdict::stress, "stress"},
                                                  {Verdict::not_measured, "not_measured"},
                                                  {Verdict::not_applicable, "not_applicable"}}};
constexpr std::array<Word<Owner>, 9> kOwners{{{Owner::none, "none"},
                                              {Owner::solver, "SOLVER"},
                                              {Owner::rig, "RIG"},
                                              {Owner::motion, "MOTION"},
                                              {Owner::weights, "WEIGHTS"},
                                              {Owner::skeleton, "SKELETON"},
                                              {Owner::pose, "POSE"},
                                              {Owner::input, "INPUT"},
                                              {Owner::tool, "TOOL"}}};
constexpr std::array<Word<Role>, 3> kRoles{
    {{Role::proposed, "proposed"}, {Role::reference, "reference"}, {Role::canary, "canary"}}};

template <class Table, class E>
std::string_view word_of(const Table& table, E value) {
  for (const auto& [key, word] : table)
    if (key == value) return word;
  return "not_measured";  // a value outside the enumeration is not a pass
}

template <class E, class Table>
std::optional<E> value_of(const Table& table, std::string_view wanted) {
  for (const auto& [key, word] : table)
    if (word == wanted) return key;
  return std::nullopt;
}

}  // namespace

std::string_view verdict_word(Verdict verdict) { return word_of(kVerdicts, verdict); }
std::string_view owner_word(Owner owner) { return word_of(kOwners, owner); }
std::string_view role_word(Role role) { return word_of(kRoles, role); }

std::optional<Verdict> verdict_from_word(std::string_view word) {
  return value_of<Verdict>(kVerdicts, word);
}
std::optional<Owner> owner_from_word(std::string_view word) {
  return value_of<Owner>(kOwners, word);
}
std::optional<Role> role_from_word(std::string_view word) { return value_of<Role>(kRoles, word); }

}  // namespace backbend::validate
