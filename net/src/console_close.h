// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#ifdef _WIN32
#include <windows.h>
// After it.
#include <csignal>
#endif

namespace tandem::net {

#ifdef _WIN32

/// A console that is closed, or a user who logs off, is as Ctrl+Break to who listens for that.
/// Windows ends the process as soon as this returns, or after 5 s: so it does not return, and the
/// process ends by its own.
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

/// From the first call on. Never undone: while a console closes, its list of functions is locked.
inline void listen_to_console_close() {
  [[maybe_unused]] static const BOOL listens = SetConsoleCtrlHandler(on_console_close, TRUE);
}

#else

inline void listen_to_console_close() {}

#endif

}  // namespace tandem::net
