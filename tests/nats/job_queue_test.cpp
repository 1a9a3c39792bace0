// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "job_queue.h"

#include <atomic>
#include <mutex>
#include <vector>

#include "support/catch.h"
#include "support/eventually.h"

namespace tandem::nats::job_queue_test {

using tandem::testing::eventually;

TEST_CASE("job queue: a blocked job holds up its owner's later jobs, and no other's",
          "[nats][fault]") {
  std::atomic<bool> possible = false;
  std::atomic<int> tried = 0;
  std::mutex mutex;
  std::vector<int> done;
  const auto does = [&](int number) {
    return [&, number] {
      const std::scoped_lock lock(mutex);
      done.push_back(number);
      return true;
    };
  };
  const auto size = [&] {
    const std::scoped_lock lock(mutex);
    return done.size();
  };
  const int first = 1, second = 2;
  JobQueue queue;
  queue.add(&first, [&] {
    ++tried;
    return possible.load();
  });
  for (int i = 0; i < 10; ++i) {
    queue.add(&first, does(i));
    queue.add(&second, does(100 + i));
  }
  REQUIRE(eventually([&] { return size() == 10; }));
  CHECK(queue.waiting() == 11);
  REQUIRE(eventually([&] { return tried >= 2; }));
  CHECK(size() == 10);
  possible = true;
  REQUIRE(eventually([&] { return queue.waiting() == 0; }));
  std::vector<int> expected;
  for (int i = 0; i < 20; ++i) expected.push_back(i < 10 ? 100 + i : i - 10);
  CHECK(done == expected);
}

}  // namespace tandem::nats::job_queue_test
