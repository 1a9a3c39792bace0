#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Two peers in two homes, each behind a NAT of its own, that nobody has opened: network namespaces, with
# a host between them on which coturn is STUN and TURN server.
#   tests/net/ice.sh BIN stun    NATs that keep a port for all targets: they meet straight
#   tests/net/ice.sh BIN move    as stun, and then both get other addresses at the same time
#   tests/net/ice.sh BIN turn    NATs that take another port for each target: they meet by the server
#   tests/net/ice.sh BIN none    as turn, without a TURN server: they must not meet
# Exits with 77 where this machine cannot do it, and says what is missing.
set -euo pipefail

bin=$1
way=$2
source "$(dirname "${BASH_SOURCE[0]}")/hosts.sh"
[[ -x $bin/tandem-key ]] || skip "built without libsodium: no UDP"
command -v nft >/dev/null || skip "there is no nft command (Debian: nftables)"
command -v turnserver >/dev/null || skip "there is no turnserver command (Debian: coturn)"

net=tandem-net-$$
add_host "$net"
ip -n "$net" addr add 192.0.2.1/32 dev lo
ip netns exec "$net" sysctl -qw net.ipv4.ip_forward=1
# Homes' own addresses lead nowhere, silently as in the world: coturn ends a session where it is told
# that there is no route.
ip link add name void netns "$net" type veth peer name voidend netns "$net" 2>"$folder/why" ||
  skip "no veth pairs here: $(cat "$folder/why")"
ip -n "$net" link set void up
ip -n "$net" link set voidend up
ip -n "$net" route add default dev void
ip -n "$net" neigh add 10.0.0.2 lladdr 02:00:00:00:00:01 dev void
for side in 1 2; do
  home=tandem-home$side-$$ nat=tandem-nat$side-$$
  add_host "$home"
  add_host "$nat"
  ip link add name lan netns "$home" type veth peer name home netns "$nat" 2>"$folder/why" ||
    skip "no veth pairs here: $(cat "$folder/why")"
  ip link add name ext netns "$nat" type veth peer name nat$side netns "$net"
  # Both homes have the same addresses, as homes have.
  ip -n "$home" addr add 10.0.0.2/24 dev lan
  ip -n "$nat" addr add 10.0.0.1/24 dev home
  ip -n "$nat" addr add 198.51.100.$side/32 dev ext
  ip -n "$home" link set lan up
  ip -n "$nat" link set home up
  ip -n "$nat" link set ext up
  ip -n "$net" link set nat$side up
  ip -n "$home" route add default via 10.0.0.1
  ip -n "$nat" route add default via 192.0.2.1 dev ext onlink
  ip -n "$net" route add 198.51.100.$side/32 dev nat$side
  ip netns exec "$nat" sysctl -qw net.ipv4.ip_forward=1
  random=
  [[ $way == stun || $way == move ]] || random=" random"
  ip netns exec "$nat" nft -f - 2>"$folder/why" <<RULES || skip "this kernel has no NAT: $(head -1 "$folder/why")"
table ip nat {
  chain leaving {
    type nat hook postrouting priority 100;
    oifname "ext" masquerade$random
  }
}
table ip filter {
  chain through {
    type filter hook forward priority 0; policy drop;
    iifname "home" accept
    ct state established,related accept
  }
  chain here {
    type filter hook input priority 0; policy drop;
    iifname != "ext" accept
    ct state established,related accept
  }
}
RULES
done

# Without Debian's settings, which refuse the old form of the question that libnice asks.
ip netns exec "$net" turnserver -n --no-cli --no-tls --no-dtls --listening-ip 192.0.2.1 \
  --relay-ip 192.0.2.1 --user tandem:secret --realm tandem --lt-cred-mech --fingerprint \
  --no-multicast-peers --log-file stdout --pidfile "$folder/turn.pid" \
  --userdb "$folder/turn.db" >"$folder/turn.out" 2>&1 &
server=$!
pids+=("$server")

(umask 077 && "$bin/tandem-key" >"$folder/key")
turn=
[[ $way != turn ]] || turn='turn = "tandem:secret@192.0.2.1:3478"'
for side in 1 2; do
  cat >"$folder/$side.toml" <<CONFIG
id = $side
[network]
listen = 0
key = "key"
stun = "192.0.2.1:3478"
$turn
[network.ice]
"from$side.ice" = "from$((3 - side)).ice"
[log]
file = "log$side"
CONFIG
done
# A peer that asks before it listens gets no answer.
for ((i = 0; i < 40; ++i)); do
  if ip netns exec "$net" ss -lun 2>/dev/null | grep -q '192.0.2.1:3478'; then break; fi
  sleep 0.25
done
for side in 1 2; do
  on_host "tandem-home$side-$$" "$bin/tandem-peer" cubes --config "$folder/$side.toml"
done

met() { grep -q 'event=peer_connected' "$folder/log$1" 2>/dev/null; }
patience=30
[[ $way != none ]] || patience=15
for ((i = 0; i < 2 * patience; ++i)); do
  if met 1 && met 2; then break; fi
  sleep 0.5
done
grep -h 'event=ice' "$folder"/log[12] || true
if [[ $way == none ]]; then
  if met 1 || met 2; then
    echo "they met where no way leads: these NATs let too much through for this test" >&2
    exit 1
  fi
  exit 0
fi
met 1 && met 2 || {
  echo "the peers did not meet" >&2
  tail -n 20 "$folder"/log[12] "$folder/turn.out" >&2
  exit 1
}
# Report and reality: peers with a direct path must not go through the server.
route=$(grep -h 'event=ice.*state=connected' "$folder"/log[12])
if [[ $way == stun ]] && grep -q relay <<<"$route"; then
  echo "they met by the relay" >&2
  exit 1
fi
if [[ $way == turn ]] && ! grep -q relay <<<"$route"; then
  echo "they met without the relay: these NATs let too much through for this test" >&2
  exit 1
fi
[[ $way == move ]] || exit 0

# Neither hears the other any more, and nobody else is in the session: each loses it with the reason,
# makes a new description where its way has failed, and they meet again.
for side in 1 2; do
  ip -n "tandem-nat$side-$$" addr add 198.51.100.1$side/32 dev ext
  ip -n "tandem-nat$side-$$" addr delete 198.51.100.$side/32 dev ext
  ip -n "tandem-nat$side-$$" route replace default via 192.0.2.1 dev ext onlink
  ip -n "$net" route add 198.51.100.1$side/32 dev nat$side
done
met_again() { [[ $(grep -c 'event=peer_connected' "$folder/log$1") -ge 2 ]]; }
for ((i = 0; i < 160; ++i)); do
  if met_again 1 && met_again 2; then break; fi
  sleep 0.5
done
grep -hE 'event=(ice|peer_)' "$folder"/log[12]
grep -q 'event=peer_lost.*nothing heard' "$folder/log1" || {
  echo "the first session did not end for silence" >&2
  exit 1
}
met_again 1 && met_again 2 || {
  echo "the peers did not meet again" >&2
  exit 1
}
