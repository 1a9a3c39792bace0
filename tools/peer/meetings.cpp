// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/meetings.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "tandem/ice/ice_path.h"

namespace tandem::demos {

/// A permanent path to one peer that wraps its present connection.
class MeetingWay final : public net::DatagramPath {
 public:
  void use(std::shared_ptr<ice::IcePath> path) {
    std::shared_ptr<ice::IcePath> old;
    {
      const std::scoped_lock lock(mutex_);
      old = std::exchange(path_, std::move(path));
      path_->receive(receive_);
    }
    if (old) old->receive({});
  }
  void send(std::span<const std::byte> datagram) override {
    const std::scoped_lock lock(mutex_);
    if (path_) path_->send(datagram);
  }
  void receive(Receive receive) override {
    const std::scoped_lock lock(mutex_);
    receive_ = std::move(receive);
    if (path_) path_->receive(receive_);
  }
  std::size_t max_datagram() const override {
    const std::scoped_lock lock(mutex_);
    return path_ ? path_->max_datagram() : DatagramPath::max_datagram();
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<ice::IcePath> path_;
  Receive receive_;
};

namespace {

using ice::IcePath;

constexpr std::size_t kMaxDescription = 64 * 1024;  // bytes, limit for reading

std::string read_some(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  std::string out(kMaxDescription, '\0');
  file.read(out.data(), static_cast<std::streamsize>(out.size()));
  out.resize(static_cast<std::size_t>(file.gcount()));
  return out;
}

/// Written atomically, since the reader may read at any time. For its owner alone.
void write_whole(const std::string& name, const std::string& text) {
  const std::string part = name + ".part";
  {
    std::ofstream file(part, std::ios::binary);
    std::error_code ignored;
    std::filesystem::permissions(
        part, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write, ignored);
    file << text;
    if (!file.flush()) throw std::runtime_error(part + " cannot be written");
  }
  std::filesystem::rename(part, name);
}

}  // namespace

class Meetings::Impl {
 public:
  Impl(const PeerConfig& config, Network& network, Log& log) : log_(log) {
    if (config.stun) options_.stun = {*config.stun};
    if (config.turn) {
      options_.turn = {{config.turn->address, config.turn->user, config.turn->password}};
    }
    for (const auto& [own, other] : config.meetings) {
      Meeting& added = meetings_.emplace_back();
      added.own = own;
      added.other = other;
      std::error_code ignored;
      std::filesystem::remove(own, ignored);  // of an earlier start, now invalid
      network.connect(added.way);
    }
  }

  void look() {
    for (Meeting& each : meetings_) {
      try {
        look(each);
      } catch (const std::exception& error) {
        // Files and servers may appear later.
        const std::string what = error.what();
        if (what != each.trouble) log_.line(Level::Warn, "ice", {{"what", what}});
        each.trouble = what;
      }
    }
  }

 private:
  struct Meeting {
    std::string own;
    std::string other;
    std::shared_ptr<MeetingWay> way = std::make_shared<MeetingWay>();
    std::shared_ptr<IcePath> path;
    IcePath::State told = IcePath::State::Gathering;
    std::string had;  // the other's last description, used or refused
    std::string trouble;
  };

  void look(Meeting& meeting) {
    if (!meeting.path || meeting.path->state() == IcePath::State::Failed) {
      meeting.path = std::make_shared<IcePath>(options_);
      meeting.way->use(meeting.path);
      meeting.told = IcePath::State::Gathering;
    }
    IcePath& path = *meeting.path;
    const IcePath::State state = path.state();
    if (state != std::exchange(meeting.told, state)) {
      if (state == IcePath::State::Ready) write_whole(meeting.own, path.description());
      log_.line(Level::Info, "ice",
                {{"file", meeting.own}, {"state", ice::to_string(state)}, {"route", path.route()}});
    }
    if (state != IcePath::State::Ready) return;
    const std::string text = read_some(meeting.other);
    if (text.empty() || text == meeting.had) return;
    meeting.had = text;
    path.connect(text);
  }

  Log& log_;
  ice::IceOptions options_;
  std::vector<Meeting> meetings_;
};

Meetings::Meetings(const PeerConfig& config, Network& network, Log& log)
    : impl_(std::make_unique<Impl>(config, network, log)) {}
Meetings::~Meetings() = default;
void Meetings::look() { impl_->look(); }

}  // namespace tandem::demos
