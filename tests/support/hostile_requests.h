// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "support/catch.h"
#include "support/web_client.h"

namespace tandem::testing {

/// A page's server on 127.0.0.1, which serves at least "" and "main.js".
struct Served {
  std::uint16_t port = 0;
  std::string root;        ///< "/TOKEN/"
  std::string socket;      ///< below it
  std::string help;        ///< a part of what is said to who has lost part of the address
  bool has_https = false;  ///< whether its own origin may be https
};

inline int status_of(const Served& served, const std::string& path, const std::string& host,
                     const std::string& extra = "", const std::string& method = "GET") {
  return WebClient("127.0.0.1", served.port).get(path, host, extra, method);
}

/// Only requests with the token get the page; others get nothing.
inline void check_tokens(const Served& served) {
  const std::string host = "127.0.0.1:" + std::to_string(served.port);
  const std::string& root = served.root;
  WebClient client("127.0.0.1", served.port);
  REQUIRE(client.get(root, host) == 200);
  const std::string head = client.last_head();
  for (const char* line :
       {"Content-Type: text/html", "Content-Security-Policy: default-src 'none'",
        "Referrer-Policy: no-referrer", "Cache-Control: no-store",
        "X-Content-Type-Options: nosniff", "Cross-Origin-Resource-Policy: same-origin"}) {
    INFO(line);
    CHECK(head.find(line) != std::string::npos);
  }
  CHECK((head.find("wss://") != std::string::npos) == served.has_https);
  CHECK(client.bytes(std::stoul(head.substr(head.find("Content-Length: ") + 16))));
  CHECK(client.get(root + "main.js?pane=0", host) == 200);  // on the same connection

  std::string wrong = root;
  wrong[5] = wrong[5] == '0' ? '1' : '0';
  for (const std::string& path :
       {wrong, wrong + "main.js", wrong + served.socket, std::string("/"), std::string("*"),
        root + "other.js", root + "../" + root.substr(1), root + "../main.js",
        root + "%2e%2e/main.js", root + "../../../../etc/passwd", root.substr(0, 32), root + '/',
        root + served.socket}) {
    INFO(path);
    CHECK(status_of(served, path, host) == 404);
  }
  for (const char* method : {"POST", "HEAD", "PUT", "OPTIONS", "DELETE"}) {
    CHECK(status_of(served, root, host, "", method) == 404);
  }
  // The help page does not reveal the token.
  const auto said = [&](const std::string& path) {
    WebClient other("127.0.0.1", served.port);
    REQUIRE(other.get(path, host) == 404);
    const std::string answer = other.last_head();
    return other.bytes(std::stoul(answer.substr(answer.find("Content-Length: ") + 16)))
        .value_or("");
  };
  const std::string help = said("/");
  CHECK(help.find(served.help) != std::string::npos);
  CHECK(help.find(root.substr(1, 32)) == std::string::npos);
  for (const std::string& path : {wrong, wrong.substr(0, 33), root + "other.js"}) {
    CHECK(said(path) == help);
  }
  // A request without the last slash is redirected to the page.
  const std::string bare = root.substr(0, 33);
  for (const std::string query : {"", "?pane=0"}) {
    WebClient other("127.0.0.1", served.port);
    REQUIRE(other.get(bare + query, host) == 308);
    CHECK(other.last_head().find("Location: " + root + query + "\r\n") != std::string::npos);
  }
  CHECK(status_of(served, bare, "evil.example") == 404);
  CHECK(status_of(served, bare, host, "", "POST") == 404);
}

/// Another site's page and another name of the machine are refused, and told nothing.
inline void check_names(const Served& served) {
  const std::string& root = served.root;
  const std::string port = ':' + std::to_string(served.port);
  const std::string host = "127.0.0.1" + port;
  CHECK(status_of(served, root, "localhost" + port) == 200);
  CHECK(status_of(served, root, host, "Origin: http://" + host + "\r\n") == 200);
  for (const std::string& name : {"evil.example" + port, std::string("127.0.0.1"),
                                  "127.0.0.2" + port, std::string("127.0.0.1:1"), port,
                                  std::string(), "127.0.0.1.evil.example" + port, "[::1]" + port}) {
    INFO(name);
    WebClient client("127.0.0.1", served.port);
    CHECK(client.get(root, name) == 404);
    CHECK(client.last_head().find("Content-Length: 0\r\n") != std::string::npos);
  }
  CHECK(status_of(served, root, host, "Host: " + host + "\r\n") != 200);
  const auto open = [&](const std::string& origin) {
    WebClient client("127.0.0.1", served.port);
    return client.open(root + served.socket, host, "Origin: " + origin + "\r\n");
  };
  for (const std::string& origin :
       {std::string("http://evil.example"), std::string("https://evil.example"),
        std::string("null"), "http://localhost" + port, std::string("http://127.0.0.1")}) {
    INFO(origin);
    CHECK(status_of(served, root, host, "Origin: " + origin + "\r\n") == 404);
    CHECK(open(origin) == 404);
  }
  CHECK(open("http://" + host) == 101);
  CHECK(open("https://" + host) == (served.has_https ? 101 : 404));
}

/// An invalid or too long request ends only its own connection.
inline void check_malformed(const Served& served) {
  const std::string host = "127.0.0.1:" + std::to_string(served.port);
  const std::string begin = "GET " + served.root + " HTTP/1.1\r\nHost: " + host + "\r\n";
  const std::vector<std::string> bad = {
      std::string(64, '\0'),
      "GET\r\n\r\n",
      begin + "X: " + std::string(9000, 'x') + "\r\n\r\n",  // more than 8 KiB of head
      "GET /" + std::string(20000, 'x') + " HTTP/1.1\r\n\r\n",
      begin + "Content-Length: 5\r\n\r\nhello",
  };
  for (const std::string& bytes : bad) {
    WebClient client("127.0.0.1", served.port);
    client.send(bytes);
    const int status = WebClient::status(client.head());
    INFO(bytes.substr(0, 20) << " of " << bytes.size());
    CHECK((status == 400 || status == 0));  // or it is reset, with what it still sends on its way
    CHECK_FALSE(client.bytes(1));
  }
  CHECK(status_of(served, served.root, host) == 200);
}

/// Beyond the bound the oldest goes of those that have not shown the token.
/// @pre the server has room for `bound`, and nobody else is there
inline void check_flood(const Served& served, std::size_t bound) {
  const std::string host = "127.0.0.1:" + std::to_string(served.port);
  {
    std::vector<std::unique_ptr<WebClient>> idle;
    for (std::size_t i = 0; i < bound; ++i) {
      idle.push_back(std::make_unique<WebClient>("127.0.0.1", served.port));
    }
    CHECK(status_of(served, served.root, host) == 200);
    CHECK(idle.front()->get(served.root, host) == 0);
    CHECK(idle.back()->get(served.root, host) == 200);
  }
  int status = 0;
  for (int i = 0; i < 100 && status != 200; ++i) {
    std::this_thread::sleep_for(std::chrono::microseconds(20000));
    status = status_of(served, served.root, host);
  }
  CHECK(status == 200);
}

}  // namespace tandem::testing
