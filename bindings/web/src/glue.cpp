// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Transports whose functions are JavaScript's: the module imports them, as function pointers of C
// cannot name them. `user` is the number that JavaScript knows a transport by.
#include "tandem/c/tandem.h"

#define TANDEM_IMPORT(name) __attribute__((import_module("tandem"), import_name(name)))

extern "C" {

TANDEM_IMPORT("post")
int32_t tandem_js_post(uint32_t user, uint64_t to, const void* bytes, size_t size,
                       int32_t delivery);
TANDEM_IMPORT("drain") void tandem_js_drain(uint32_t user, const void* inbox);
TANDEM_IMPORT("peers") void tandem_js_peers(uint32_t user, const void* list);
TANDEM_IMPORT("drop") void tandem_js_drop(uint32_t user, uint64_t peer, const char* reason);

}  // extern "C"

namespace {

/// Memory lent to JavaScript during one call.
struct Inbox {
  tandem_receive receive;
  void* inbox;
};
struct List {
  tandem_list_peer list;
  void* into;
};

uint32_t number(void* user) { return static_cast<uint32_t>(reinterpret_cast<uintptr_t>(user)); }

}  // namespace

extern "C" {

tandem_transport* tandem_web_transport_create(uint32_t user, uint64_t self, uint32_t max_packet,
                                              tandem_error* error) {
  const tandem_transport_def def{
      .user = reinterpret_cast<void*>(static_cast<uintptr_t>(user)),
      .self = self,
      .post =
          [](void* to_user, uint64_t to, const void* bytes, size_t size, tandem_delivery delivery) {
            return tandem_js_post(number(to_user), to, bytes, size, delivery);
          },
      .drain =
          [](void* of_user, tandem_receive receive, void* inbox) {
            const Inbox lent{receive, inbox};
            tandem_js_drain(number(of_user), &lent);
          },
      .peers =
          [](void* of_user, tandem_list_peer list, void* into) {
            const List lent{list, into};
            tandem_js_peers(number(of_user), &lent);
          },
      .drop = [](void* of_user, uint64_t peer,
                 const char* reason) { tandem_js_drop(number(of_user), peer, reason); },
      .max_packet = max_packet};
  return tandem_transport_create(&def, error);
}

void tandem_web_receive(const Inbox* lent, uint64_t from, const void* bytes, size_t size) {
  lent->receive(lent->inbox, from, bytes, size);
}

void tandem_web_list(const List* lent, uint64_t peer, int32_t connected) {
  lent->list(lent->into, peer, connected);
}

}  // extern "C"
