// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <stdexcept>

#include "guard.h"

using namespace tandem::c;

tandem_session* tandem_session_create_udp(tandem_world* /*world*/, const tandem_udp_def* /*udp*/,
                                          const tandem_session_def* /*def*/, tandem_error* error) {
  return made_by(error, []() -> tandem_session* {
    throw std::runtime_error("this build has no UDP: libsodium was not found");
  });
}
