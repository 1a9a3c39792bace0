// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A large square on which any number of people carry, push and throw things over a NATS server; all
// of them in this process, headless:
//
//   plaza --server 127.0.0.1:4222 --people 200
//
// demos/run.sh plaza starts its own server.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "arguments/arguments.h"
#include "plaza/square.h"

namespace {

using namespace tandem::demos;

std::string usage() {
  return "usage: plaza [--server HOST:PORT] [--people N] [--bodies N] [--side M] [--seconds S]\n"
         "  --server     of NATS with JetStream, 127.0.0.1:4222\n"
         "  --people     who walk, carry, push and throw, 1 to 5000: 20\n"
         "  --bodies     crates and balls, 0 to 100000: 1000\n"
         "  --side       m, of the square, 2 to 10000: 100\n"
         "  --density    m^2 for each person, instead of --side; and one body for each person\n"
         "  --seconds    s of session time that are counted, after 3 s to settle: 20\n"
         "  --near       m: whom a person hears; bodies half as far; 2 to 50: 8\n"
         "  --hz         steps and --update-hz states a second: 60, 20\n"
         "  --per-hub    people who share a connection: 32\n"
         "  --direct     so many of the nearest are spoken to by UDP, 0 to 256: 16\n"
         "  --no-far     no summaries of cells\n"
         "  --transport  nats, or udp: everybody with everybody, for up to 40 people\n"
         "  --seed       of places and of what people do: 1\n"
         "  --json FILE  the figures; - is standard output\n"
         "  --quiet\n";
}

PlazaOptions read(std::span<const std::string_view> words) {
  PlazaOptions out;
  double density = 0.0;
  read_arguments(
      words,
      {{"--server", [&](Argument& in) { out.server = in.text(); }},
       {"--people",
        [&](Argument& in) {
          out.people = in.number(std::size_t{1}, std::size_t{5000}, "from 1 to 5000");
        }},
       {"--bodies",
        [&](Argument& in) {
          out.bodies = in.number(std::size_t{0}, std::size_t{100000}, "from 0 to 100000");
        }},
       {"--side", [&](Argument& in) { out.side = in.number(2.0, 1e4, "from 2 to 10000 m"); }},
       {"--density", [&](Argument& in) { density = in.number(0.5, 1e4, "from 0.5 to 10000 m^2"); }},
       {"--seconds", [&](Argument& in) { out.seconds = in.number(1.0, 1e5, "from 1 to 1e5 s"); }},
       {"--near", [&](Argument& in) { out.near = in.number(2.0, 50.0, "from 2 to 50 m"); }},
       {"--hz", [&](Argument& in) { out.step_hz = in.number(10.0, 1000.0, "from 10 to 1000"); }},
       {"--update-hz",
        [&](Argument& in) { out.update_hz = in.number(1.0, 1000.0, "from 1 to 1000"); }},
       {"--per-hub",
        [&](Argument& in) {
          out.per_hub = in.number(std::size_t{1}, std::size_t{5000}, "from 1 to 5000");
        }},
       {"--direct",
        [&](Argument& in) {
          out.direct = in.number(std::size_t{0}, std::size_t{256}, "from 0 to 256");
        }},
       {"--no-far", [&](Argument&) { out.tells_far = false; }},
       {"--transport",
        [&](Argument& in) {
          const std::string name = in.text();
          if (name != "nats" && name != "udp") refuse("--transport", name, "nats or udp");
          out.wire = name == "udp" ? PlazaWire::Udp : PlazaWire::Nats;
        }},
       {"--seed",
        [&](Argument& in) {
          out.seed = in.number(std::uint64_t{1}, ~std::uint64_t{0}, "above 0");
        }},
       {"--json", [&](Argument& in) { out.json = in.text(); }},
       {"--quiet", [&](Argument&) { out.quiet = true; }}});
  if (density > 0.0) {
    out.side = std::sqrt(density * static_cast<double>(out.people));
    out.bodies = out.people;
  }
  if (out.wire == PlazaWire::Udp && out.people > 40) {
    refuse("--people", std::to_string(out.people), "at most 40 over UDP");
  }
  return out;
}

void write(std::FILE* file, const PlazaOptions& options, const SquareReport& r) {
  const double people = static_cast<double>(options.people);
  const auto spread = [&](const char* name, const Spread& s) {
    std::fprintf(file, " \"%s\": {\"p50\": %.4f, \"p95\": %.4f, \"p99\": %.4f, \"max\": %.3f},\n",
                 name, s.p50, s.p95, s.p99, s.most);
  };
  std::fprintf(file, "{\"people\": %zu, \"bodies\": %zu, \"side\": %.2f,\n", options.people,
               options.bodies, options.side);
  std::fprintf(file, " \"session_s\": %.2f, \"wall_s\": %.2f,\n", r.session_s, r.wall_s);
  std::fprintf(file, " \"cpu_ms_per_person_s\": %.4f,\n", 1e3 * r.cpu_s / people / r.session_s);
  std::fprintf(file, " \"kbit_in\": %.2f, \"kbit_out\": %.2f,\n", r.kbit_in, r.kbit_out);
  std::fprintf(file, " \"messages_in\": %.2f, \"messages_out\": %.2f, \"summaries\": %.2f,\n",
               r.messages_in, r.messages_out, r.summaries);
  std::fprintf(file, " \"connected\": %.3f, \"direct\": %.3f, \"simulated\": %.3f,\n", r.connected,
               r.direct, r.simulated);
  std::fprintf(file, " \"cells\": %.2f, \"direct_in\": %.2f, \"direct_out\": %.2f,\n", r.cells,
               r.direct_in, r.direct_out);
  spread("moving_mm", r.moving_mm);
  spread("resting_mm", r.resting_mm);
  std::fprintf(
      file, " \"taken\": %llu, \"crossings\": %llu, \"written\": %llu, \"refused\": %llu,\n",
      static_cast<unsigned long long>(r.taken), static_cast<unsigned long long>(r.crossings),
      static_cast<unsigned long long>(r.written), static_cast<unsigned long long>(r.refused));
  std::fprintf(file, " \"people_told\": %u, \"bodies_lost\": %zu, \"bodies_twice\": %zu}\n",
               r.people_told, r.bodies_lost, r.bodies_twice);
}

int run(std::span<const std::string_view> words) {
  const PlazaOptions options = read(words);
  if (!options.json.empty() && options.json != "-") {
    require_writable_file("--json", options.json);
  }
  Square square(options);
  const SquareReport report = square.run();
  if (options.json.empty() || options.json == "-") {
    write(stdout, options, report);
  } else {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
        std::fopen(options.json.c_str(), "w"), std::fclose);
    write(file.get(), options, report);
  }
  return report.bodies_lost + report.bodies_twice == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) { return program_main(argc, argv, usage(), run); }
