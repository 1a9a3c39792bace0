// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

// Sockets by their names in POSIX, also on Windows; there an int holds each of them.
#ifdef _WIN32
#include <winsock2.h>
#include <ws2tcpip.h>
#else
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#endif

#include <cstddef>

#ifdef _WIN32

constexpr int MSG_NOSIGNAL = 0;

inline int poll(pollfd* sockets, ULONG count, int timeout_ms) {
  return WSAPoll(sockets, count, timeout_ms);
}
// Data of any bytes; Windows wants characters.
template <class Byte>
auto send(SOCKET socket, const Byte* bytes, std::size_t size, int flags) {
  return send(socket, reinterpret_cast<const char*>(bytes), static_cast<int>(size), flags);
}
template <class Byte>
auto recv(SOCKET socket, Byte* bytes, std::size_t size, int flags) {
  return recv(socket, reinterpret_cast<char*>(bytes), static_cast<int>(size), flags);
}
template <class Byte>
auto sendto(SOCKET socket, const Byte* bytes, std::size_t size, int flags, const sockaddr* to,
            socklen_t to_size) {
  return sendto(socket, reinterpret_cast<const char*>(bytes), static_cast<int>(size), flags, to,
                to_size);
}
template <class Byte>
auto recvfrom(SOCKET socket, Byte* bytes, std::size_t size, int flags, sockaddr* from,
              socklen_t* from_size) {
  return recvfrom(socket, reinterpret_cast<char*>(bytes), static_cast<int>(size), flags, from,
                  from_size);
}
template <class Value>
int setsockopt(SOCKET socket, int level, int name, const Value* value, std::size_t size) {
  return setsockopt(socket, level, name, reinterpret_cast<const char*>(value),
                    static_cast<int>(size));
}

#endif

namespace tandem::testing {

inline int close_socket(int socket) {
#ifdef _WIN32
  return closesocket(static_cast<SOCKET>(socket));
#else
  return close(socket);
#endif
}

/// One for IPv4 that never waits. @param kind  SOCK_STREAM or SOCK_DGRAM
inline int nonblocking_socket(int kind) {
#ifdef _WIN32
  const SOCKET made = socket(AF_INET, kind, 0);
  u_long on = 1;
  ioctlsocket(made, FIONBIO, &on);
  return static_cast<int>(made);
#else
  return socket(AF_INET, kind | SOCK_NONBLOCK, 0);
#endif
}

inline int process_id() {
#ifdef _WIN32
  return static_cast<int>(GetCurrentProcessId());
#else
  return static_cast<int>(getpid());
#endif
}

/// Sockets of Windows need it once in a process.
inline void start_sockets() {
#ifdef _WIN32
  [[maybe_unused]] static const int started = [] {
    WSADATA data;
    return WSAStartup(MAKEWORD(2, 2), &data);
  }();
#endif
}

}  // namespace tandem::testing
