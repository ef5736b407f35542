#pragma once
#include <filesystem>
#include <string>

namespace backbend::render {

/// The file that this code is linked into: the program, or the library of another program that
/// loaded it, as Python's module. What belongs to it is looked for from here.
std::filesystem::path own_file();

/// A file of ours that is started or loaded by name. <prefix>/bin/backbend has it in
/// <prefix>/libexec/backbend, a build folder in its own libexec/backbend; programs of a build are
/// up to two folders deep, Python's modules four. Where it is missing, its place beside the
/// program.
std::filesystem::path libexec_file(const std::string& name);

}  // namespace backbend::render
