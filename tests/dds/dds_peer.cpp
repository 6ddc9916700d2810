// A peer in a process of its own.
//   dds_peer read DOMAIN TOPIC TYPE     reads reliably, until it is killed
//   dds_peer flood DOMAIN TOPIC TYPE    writes garbage tens of thousands a second
//   dds_peer packets DOMAIN             sends damaged RTPS packets to the ports of all participants, as fast
//   as it goes
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "tests/dds/fast_peer.hpp"

namespace {

/// Tens of thousands a second are a flood; all of a processor would be taken from the tests beside.
void rest() {
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

int send_packets(int domain) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
  if (fd < 0) return 1;
  unsigned state = 1;
  const auto random = [&state] { return state = state * 1664525u + 1013904223u, state >> 16; };
  for (unsigned sent = 1;; ++sent) {
    if (sent % 64 == 0) rest();
    // a header of RTPS 2.1 and sub-messages of random kinds, lengths and contents
    unsigned char packet[1400] = {'R', 'T', 'P', 'S', 2, 1, 1, 16};
    const std::size_t size = 20 + random() % 1380;
    for (std::size_t i = 8; i < size; ++i) packet[i] = static_cast<unsigned char>(random());
    constexpr unsigned char kKinds[] = {0x06, 0x07, 0x08, 0x09, 0x0e, 0x12, 0x13, 0x15, 0x16};
    packet[20] = kKinds[random() % sizeof kKinds];
    packet[21] |= 1;
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * domain + static_cast<int>(random() % 20)));
    (void)::sendto(fd, packet, size, 0, reinterpret_cast<sockaddr*>(&to), sizeof to);
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace std::chrono_literals;
  if (argc == 3 && std::string(argv[1]) == "packets") return send_packets(std::atoi(argv[2]));
  if (argc != 5) return 2;
  const std::string mode = argv[1];
  colift::tests::FastPeer peer(std::atoi(argv[2]));
  if (mode == "read") {
    const auto reader = peer.reader(argv[3], argv[4]);
    for (;;) (void)reader->next(1000ms);
  }
  const auto writer = peer.writer(argv[3], argv[4], {true, false, 5});
  colift::tests::Bytes garbage(2000, 0xff);
  garbage[0] = 0, garbage[1] = 1, garbage[2] = 0, garbage[3] = 0;
  for (unsigned i = 0;; ++i) {
    garbage[4 + i % 1900] ^= static_cast<unsigned char>(i);
    (void)writer->write(garbage);
    if (i % 20 == 0) rest();
  }
}
