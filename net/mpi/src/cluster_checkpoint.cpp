// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <stdexcept>

#include "checkpoint.h"
#include "cluster_impl.h"

namespace tandem::mpi {

void Cluster::Impl::save(const std::string& path) {
  Bytes section;
  MessageWriter out(section);
  out.put(static_cast<std::uint64_t>(part_.own().size()));
  for (const std::uint32_t slot : part_.own()) part_.write(slot, section);
  for (const pbd::Contact& contact : world_.contacts()->contacts()) {
    write_contact(part_.named(contact), out);
  }
  if (seam_ != nullptr) {
    for (const pbd::Contact& contact : seam_->rows().contacts()) {
      write_contact(part_.named(contact), out);
    }
  }
  write_checkpoint(ranks_, path, steps_, section);
}

void Cluster::Impl::load(const std::string& path) {
  if (started_ || !part_.own().empty()) {
    throw std::runtime_error("Cluster::load: must come before start() and dynamic bodies");
  }
  const Checkpoint checkpoint = read_checkpoint(ranks_, path);
  arrived_.assign(world_.slot_count(), 0);
  for (const Bytes& section : checkpoint.sections) read_section(section);
  steps_ = checkpoint.steps;
  started_ = true;
  if (balance_ != nullptr) {
    share_out();
    return;
  }
  std::vector<pbd::Contact> contacts;
  for (NamedContact& named : alone_) {
    if (part_.place(named)) contacts.push_back(named.contact);
  }
  alone_.clear();
  for (const auto& block : world_.blocks()) {
    if (block.get() == world_.contacts()) {
      static_cast<pbd::ContactBlock&>(*block).adopt(contacts);
    }
  }
}

}  // namespace tandem::mpi
