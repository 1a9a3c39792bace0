// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The stream of a TCP peer, in pieces of any size, and what its frames have inside.
#include "target.h"
#include "wire.h"

namespace fuzz {

using namespace tandem::net;

void run(std::span<const std::byte> input) {
  Choices choices(input);
  FrameBuffer frames(1024);
  for (int steps = 0; !choices.done() && steps < 1000 && !frames.bad(); ++steps) {
    const auto chunk = choices.bytes(1 + choices.byte());
    const auto space = frames.space();
    require(!space.empty());
    const std::size_t count = std::min(chunk.size(), space.size());
    std::copy_n(chunk.begin(), count, space.begin());
    frames.filled(count);
    while (const auto frame = frames.next()) {
      (void)decode_hello(frame->payload);
      (void)decode_welcome(frame->payload);
      if (const auto addresses = decode_addresses(frame->payload)) {
        require(addresses->size() <= kMaxAddresses);
      }
      if (const auto key = decode_key_frame(frame->payload)) {
        require(key->message.size() <= frame->payload.size());
      }
      require(decode_reason(frame->payload).size() <= kMaxReason);
    }
  }
}

std::vector<Bytes> seeds() {
  Bytes stream;
  append_frame(stream, FrameType::Hello, [](auto& writer) {
    encode(writer, Hello{.peer = 3, .incarnation = 5, .scene_hash = 6, .max_message_bytes = 65536});
  });
  append_frame(stream, FrameType::Welcome, [](auto& writer) { encode(writer, Welcome{1, 2}); });
  const PeerAddress addresses[] = {{.peer = 4, .ip = {1}, .port = 6},
                                   {.peer = 5, .ip = {2}, .port = 7}};
  append_frame(stream, FrameType::Addresses, [&](auto& writer) { encode(writer, addresses); });
  append_frame(stream, FrameType::Newest, [](auto& writer) { writer.u64(8); });
  append_frame(stream, FrameType::KeyRequest, [](auto& writer) { encode(writer, KeyFrame{}); });
  append_frame(stream, FrameType::Goodbye, [](auto& writer) { writer.u32(0x41424344); });
  Bytes whole;
  for (std::size_t at = 0; at < stream.size();) {
    const std::size_t count = std::min<std::size_t>(40, stream.size() - at);
    whole.push_back(static_cast<std::byte>(count - 1));
    whole.insert(whole.end(), stream.begin() + static_cast<std::ptrdiff_t>(at),
                 stream.begin() + static_cast<std::ptrdiff_t>(at + count));
    at += count;
  }
  return {whole};
}

}  // namespace fuzz
