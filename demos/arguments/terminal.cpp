// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "arguments/terminal.h"

#ifdef _WIN32
#include <io.h>
#include <windows.h>
#else
#include <sys/ioctl.h>
#include <unistd.h>
#endif

namespace tandem::demos {

#ifdef _WIN32

bool is_terminal(std::FILE* file) {
  const HANDLE console = reinterpret_cast<HANDLE>(_get_osfhandle(_fileno(file)));
  DWORD mode = 0;
  if (GetConsoleMode(console, &mode) == 0) return false;
  SetConsoleOutputCP(CP_UTF8);
  return SetConsoleMode(console, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING) != 0;
}

std::size_t terminal_columns() {
  CONSOLE_SCREEN_BUFFER_INFO info{};
  const int width = GetConsoleScreenBufferInfo(GetStdHandle(STD_ERROR_HANDLE), &info) != 0
                        ? info.srWindow.Right - info.srWindow.Left + 1
                        : 0;
  return width > 0 ? static_cast<std::size_t>(width) : 80;
}

#else

bool is_terminal(std::FILE* file) { return isatty(fileno(file)) == 1; }

std::size_t terminal_columns() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 80;
  return size.ws_col;
}

#endif

}  // namespace tandem::demos
