// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Runs a target on its seeds, on mutations of them by a fixed generator, and on files.
//   TARGET [--runs=N] [--seed=N] [FILE...]      0 runs: the seeds and the files alone
//   TARGET --write-seeds=DIRECTORY
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "net/protocol_support.h"
#include "target.h"

namespace {

using fuzz::Bytes;
using protocol::Dice;

Bytes mutated(const std::vector<Bytes>& seeds, Dice& dice) {
  Bytes out = seeds[dice.below(seeds.size())];
  const std::uint64_t changes = 1 + dice.below(6);
  for (std::uint64_t i = 0; i < changes; ++i) {
    const std::uint64_t kind = dice.below(6);
    const std::size_t at = out.empty() ? 0 : dice.below(out.size());
    const auto here = out.begin() + static_cast<std::ptrdiff_t>(at);
    if (kind == 0 && !out.empty()) {
      out[at] ^= static_cast<std::byte>(1 << dice.below(8));
    } else if (kind == 1 && !out.empty()) {
      constexpr std::byte kEdges[] = {std::byte{0}, std::byte{1}, std::byte{0x7f}, std::byte{0x80},
                                      std::byte{0xff}};
      out[at] = kEdges[dice.below(std::size(kEdges))];
    } else if (kind == 2) {
      out.resize(at);
    } else if (kind == 3) {
      const Bytes more = protocol::random_bytes(dice, dice.below(40));
      out.insert(here, more.begin(), more.end());
    } else if (kind == 4 && !out.empty()) {
      out.erase(here, here + static_cast<std::ptrdiff_t>(dice.below(out.size() - at) + 1));
    } else {
      const Bytes& other = seeds[dice.below(seeds.size())];
      const std::size_t from = other.empty() ? 0 : dice.below(other.size());
      out.insert(here, other.begin() + static_cast<std::ptrdiff_t>(from), other.end());
    }
    if (out.size() > 8192) out.resize(8192);
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t runs = 2000;
  std::uint64_t seed = 1;
  const std::vector<Bytes> seeds = fuzz::seeds();
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.starts_with("--runs=")) {
      runs = std::strtoull(argument.c_str() + 7, nullptr, 10);
    } else if (argument.starts_with("--seed=")) {
      seed = std::strtoull(argument.c_str() + 7, nullptr, 10);
    } else if (argument.starts_with("--write-seeds=")) {
      for (std::size_t k = 0; k < seeds.size(); ++k) {
        std::ofstream file(argument.substr(14) + "/seed" + std::to_string(k), std::ios::binary);
        file.write(reinterpret_cast<const char*>(seeds[k].data()),
                   static_cast<std::streamsize>(seeds[k].size()));
        if (!file) {
          std::fprintf(stderr, "cannot write to %s\n", argument.c_str() + 14);
          return 1;
        }
      }
      return 0;
    } else {
      std::ifstream file(argument, std::ios::binary);
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      if (!file) {
        std::fprintf(stderr, "cannot read %s\n", argv[i]);
        return 1;
      }
      fuzz::run(std::as_bytes(std::span(text)));
    }
  }
  for (const Bytes& each : seeds) fuzz::run(each);
  Dice dice(seed);
  for (std::uint64_t i = 0; i < runs; ++i) fuzz::run(mutated(seeds, dice));
  std::printf("%llu inputs\n", static_cast<unsigned long long>(seeds.size() + runs));
  return 0;
}
