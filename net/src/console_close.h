// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#ifdef _WIN32
#include <windows.h>
// After windows.h.
#include <csignal>
#endif

namespace tandem::net {

#ifdef _WIN32

/// Passes the closing of a console, a log-off or a shutdown on as Ctrl+Break, if the program
/// listens for that. Windows ends the process as soon as this returns, or after 5 s. So it never
/// returns: the program has 5 s to leave.
inline BOOL WINAPI on_console_close(DWORD event) {
  const bool closes =
      event == CTRL_CLOSE_EVENT || event == CTRL_LOGOFF_EVENT || event == CTRL_SHUTDOWN_EVENT;
  if (!closes) return FALSE;
  const auto listener = std::signal(SIGBREAK, SIG_DFL);
  if (listener == SIG_DFL || listener == SIG_IGN || listener == SIG_ERR) return FALSE;
  listener(SIGBREAK);
  Sleep(INFINITE);
  return TRUE;
}

/// Starts listening; never undone, since the console's list of handlers is locked while it closes.
inline void listen_to_console_close() {
  [[maybe_unused]] static const BOOL listens = SetConsoleCtrlHandler(on_console_close, TRUE);
}

#else

inline void listen_to_console_close() {}

#endif

}  // namespace tandem::net
