// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "tandem/c/tandem.h"
#include "tandem/consensus/transport.h"

struct tandem_transport {
  tandem::consensus::Transport* transport = nullptr;
  std::unique_ptr<tandem::consensus::Transport> owned;  ///< null if a network owns it
  std::function<std::int64_t()> clock;  ///< session time, ns; empty if the transport has none
};
