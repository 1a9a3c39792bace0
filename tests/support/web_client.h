// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "support/sockets.h"

namespace tandem::testing {

/// A browser's side of HTTP/1.1 and RFC 6455, by sockets alone: it shares nothing with the server
/// under test. Waits no longer than `patience` for anything.
class WebClient {
 public:
  static constexpr int kPatienceMs = 5000;

  /// @param receive_bytes  of the socket's buffer: small where a page is to be slow; 0 = as it is
  /// @throws std::runtime_error where nobody listens there
  WebClient(const std::string& address, std::uint16_t port, int receive_bytes = 0)
      : socket_(static_cast<int>(socket(AF_INET, SOCK_STREAM, 0))) {
    if (receive_bytes > 0) {
      setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof(receive_bytes));
    }
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    inet_pton(AF_INET, address.c_str(), &to.sin_addr);
    if (connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) != 0) {
      close_socket(socket_);
      throw std::runtime_error("web client: nobody listens on " + address);
    }
  }
  ~WebClient() { close(); }
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  void close() {
    if (socket_ >= 0) close_socket(std::exchange(socket_, -1));
  }
  bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }
  /// All of an answer's head; "" where the other side hung up.
  std::string head() {
    std::size_t end = std::string::npos;
    while ((end = buffer_.find("\r\n\r\n")) == std::string::npos) {
      if (!fill()) return "";
    }
    std::string result = buffer_.substr(0, end + 4);
    buffer_.erase(0, end + 4);
    return result;
  }
  /// So many bytes; nothing where the other side hung up before.
  std::optional<std::string> bytes(std::size_t count) {
    while (buffer_.size() < count) {
      if (!fill()) return std::nullopt;
    }
    std::string result = buffer_.substr(0, count);
    buffer_.erase(0, count);
    return result;
  }
  /// Asks for the upgrade. @param extra  further lines of the head, each with its end
  /// @return the status, 101 where it is done
  int open(const std::string& path, const std::string& host, const std::string& extra = "") {
    send("GET " + path + " HTTP/1.1\r\nHost: " + host +
         "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
         extra + "\r\n");
    return status(head());
  }
  /// The status of a plain request.
  int get(const std::string& path, const std::string& host, const std::string& extra = "",
          const std::string& method = "GET") {
    send(method + ' ' + path + " HTTP/1.1\r\nHost: " + host + "\r\n" + extra + "\r\n");
    last_head_ = head();
    return status(last_head_);
  }
  const std::string& last_head() const { return last_head_; }
  static int status(const std::string& head) {
    return head.size() > 12 ? std::stoi(head.substr(9, 3)) : 0;
  }

  /// A message of text, or of bytes, masked as a browser's are.
  bool say(std::string_view text, bool binary = false) {
    std::string frame = binary ? "\x82" : "\x81";
    if (text.size() < 126) {
      frame += static_cast<char>(0x80 | text.size());
    } else {
      const int length_bytes = text.size() < 65536 ? 2 : 8;
      frame += static_cast<char>(0x80 | (length_bytes == 2 ? 126 : 127));
      for (int i = length_bytes - 1; i >= 0; --i) {
        frame += static_cast<char>(text.size() >> (8 * i) & 0xff);
      }
    }
    constexpr std::string_view kMask = "abcd";
    frame += kMask;
    for (std::size_t i = 0; i < text.size(); ++i) {
      frame += static_cast<char>(text[i] ^ kMask[i % 4]);
    }
    return send(frame);
  }
  struct Message {
    bool binary = false;
    std::string bytes;
  };
  /// The next message; pings are answered. Nothing where the other side closed or says nothing.
  std::optional<Message> hear() {
    while (true) {
      const std::optional<std::string> start = bytes(2);
      if (!start) return std::nullopt;
      const int kind = (*start)[0] & 0x0f;
      std::uint64_t length = static_cast<unsigned char>((*start)[1]) & 0x7fU;
      if (length >= 126) {
        const std::optional<std::string> more = bytes(length == 126 ? 2 : 8);
        if (!more) return std::nullopt;
        length = 0;
        for (const char byte : *more) length = length << 8 | static_cast<unsigned char>(byte);
      }
      std::optional<std::string> body = bytes(length);
      if (!body || kind == 8) return std::nullopt;
      if (kind == 9) {
        send(std::string("\x8a") + static_cast<char>(0x80 | body->size()) + std::string(4, '\0') +
             *body);
        continue;
      }
      if (kind == 1 || kind == 2) return Message{kind == 2, std::move(*body)};
    }
  }
  /// The next message of that kind.
  std::optional<Message> hear(bool binary) {
    for (std::optional<Message> message = hear(); message; message = hear()) {
      if (message->binary == binary) return message;
    }
    return std::nullopt;
  }

 private:
  bool fill() {
    pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, kPatienceMs) <= 0) return false;
    char chunk[65536];
    const ssize_t got = recv(socket_, chunk, sizeof(chunk), 0);
    if (got <= 0) return false;
    buffer_.append(chunk, static_cast<std::size_t>(got));
    return true;
  }

  int socket_;
  std::string buffer_;
  std::string last_head_;
};

}  // namespace tandem::testing
