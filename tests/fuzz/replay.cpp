// fuzz_replay FINDINGS          tries every target on its seeds, on damaged copies of them, and on
//                               every input below FINDINGS/TARGET/
// fuzz_replay --seeds FOLDER    writes the seeds to FOLDER/TARGET/, and FOLDER/TARGET.dict
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "tests/fuzz/target.h"

namespace backbend::fuzz {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& file, std::string_view text) {
  std::ofstream out(file, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

/// libFuzzer's form of a dictionary.
std::string dictionary(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) {
    out += '"';
    for (const char c : word) {
      char code[8];
      std::snprintf(code, sizeof code, "\\x%02X", static_cast<unsigned char>(c));
      if (c < 0x20 || c == '"' || c == '\\')
        out += code;
      else
        out += c;
    }
    out += "\"\n";
  }
  return out;
}

void write_seeds(const fs::path& folder) {
  for (const Target& target : targets()) {
    const fs::path own = folder / target.name;
    fs::create_directories(own);
    int number = 0;
    for (const Bytes& seed : target.seeds())
      write(own / ("seed_" + std::to_string(number++)), text_of({seed.data(), seed.size()}));
    write(folder / (std::string(target.name) + ".dict"), dictionary(target.words));
    std::printf("%s %zu\n", std::string(target.name).c_str(), target.most_bytes);
  }
}

/// The same damage in every run: cut short, single bytes changed, stretches zeroed.
std::vector<Bytes> damaged(const Bytes& seed, std::size_t count) {
  std::mt19937 random(1);
  const auto below = [&](std::size_t end) { return random() % std::max<std::size_t>(end, 1); };
  std::vector<Bytes> out;
  for (std::size_t i = 0; i < count && !seed.empty(); ++i) {
    Bytes bytes = seed;
    if (i % 3 == 0) {
      bytes.resize(below(seed.size()));
    } else if (i % 3 == 1) {
      for (std::size_t k = 0; k <= below(4); ++k)
        bytes[below(seed.size())] = static_cast<std::uint8_t>(random());
    } else {
      const std::size_t first = below(seed.size());
      std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(first),
                bytes.begin() + static_cast<std::ptrdiff_t>(
                                    std::min(seed.size(), first + seed.size() / 10 + 1)),
                std::uint8_t{0});
    }
    out.push_back(std::move(bytes));
  }
  return out;
}

Bytes read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  Bytes bytes{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw std::runtime_error("cannot read " + file.string());
  return bytes;
}

/// So that a crash says what it was at.
std::string at_work;
void tell(const std::string& what) { at_work = what; }
[[noreturn]] void stop() {
  std::fprintf(stderr, "%s\n", at_work.c_str());
  try {
    if (const auto error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "escaped: %s\n", error.what());
  } catch (...) {
  }
  std::_Exit(1);
}

void replay(const Target& target, const fs::path& findings) {
  const std::string name(target.name);
  // Little of what is large, so that all of it fits beside the other tests.
  constexpr std::size_t kDamaged = 120;
  std::size_t tried = 0;
  const std::vector<Bytes> seeds = target.seeds();
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    tell(name + ": seed " + std::to_string(s));
    if (!target.run(seeds[s])) {
      std::fprintf(stderr, "%s: not read: %s\n", at_work.c_str(), last_refusal().c_str());
      std::_Exit(1);
    }
    ++tried;
    const std::vector<Bytes> broken = damaged(seeds[s], kDamaged);
    for (std::size_t i = 0; i < broken.size(); ++i) {
      tell(name + ": seed " + std::to_string(s) + ", damage " + std::to_string(i));
      target.run(broken[i]);
      ++tried;
    }
  }
  std::vector<fs::path> files;
  if (fs::exists(findings / name))
    for (const auto& entry : fs::directory_iterator(findings / name)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    tell(name + ": " + file.string());
    target.run(read(file));
    ++tried;
  }
  std::printf("%-14s %zu inputs, %zu of them once findings\n", name.c_str(), tried, files.size());
}

}  // namespace
}  // namespace backbend::fuzz

int main(int argument_count, char** arguments) {
  using namespace backbend::fuzz;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::set_terminate(stop);
  for (const int fatal : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS})
    std::signal(fatal, [](int) { stop(); });
  std::sort(targets().begin(), targets().end(),
            [](const Target& a, const Target& b) { return a.name < b.name; });
  if (argument_count == 3 && std::string_view(arguments[1]) == "--seeds") {
    write_seeds(arguments[2]);
  } else if (argument_count == 2) {
    for (const Target& target : targets()) replay(target, arguments[1]);
  } else {
    std::fprintf(stderr, "usage: fuzz_replay FINDINGS | --seeds FOLDER\n");
    return 2;
  }
  return 0;
}
