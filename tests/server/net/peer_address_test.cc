#include "server/net/peer_address.h"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>

namespace sweepstake::net {
namespace {

TEST(PeerAddressTest, OmitsThePortAndTheInterfaceHalfOfIpv6) {
  EXPECT_EQ(AddressOf("ipv4:192.0.2.7:5123"), "ipv4:192.0.2.7");
  EXPECT_EQ(AddressOf("ipv6:[2001:db8:1:2:3:4:5:6]:5123"), "ipv6:2001:db8:1:2::/64");
  EXPECT_EQ(AddressOf("ipv6:%5B2001:db8:1:2::9%5D:80"), "ipv6:2001:db8:1:2::/64");
  EXPECT_EQ(AddressOf("ipv6:[::ffff:192.0.2.7]:5123"), "ipv4:192.0.2.7");
  EXPECT_EQ(AddressOf("ipv6:[fe80::1%25eth0]:5123"), "ipv6:fe80::/64");
}

TEST(PeerAddressTest, TextThatIsNotAnAddressIsReturnedUnchanged) {
  for (const char* peer : {"", "unix:/run/s", "ipv6:", "ipv6:[", "ipv6:]", "fd:7", "ipv4:"})
    EXPECT_EQ(AddressOf(peer), std::string(peer) == "ipv4:" ? "ipv4" : peer);
}

TEST(PeerAddressTest, RecognisesLoopback) {
  EXPECT_TRUE(IsLoopbackAddress(AddressOf("ipv4:127.0.0.9:5123")));
  EXPECT_TRUE(IsLoopbackAddress(AddressOf("ipv6:%5B::1%5D:80")));
  EXPECT_TRUE(IsLoopbackAddress(AddressOf("unix:/run/s")));
  EXPECT_FALSE(IsLoopbackAddress(AddressOf("ipv4:128.0.0.1:5123")));
  EXPECT_FALSE(IsLoopbackAddress(AddressOf("ipv6:[::2]:80")));
}

TEST(PeerAddressTest, TheNetworkOfAPeerIsThatOfOnePerson) {
  EXPECT_EQ(NetworkOf("ipv4:203.0.113.7:5123"), "203.0.113.0/24");
  EXPECT_EQ(NetworkOf("ipv6:[::ffff:203.0.113.7]:5123"), "203.0.113.0/24");
  EXPECT_EQ(NetworkOf("ipv6:%5B2001:db8:1:2::9%5D:80"), "2001:db8:1::/48");
  for (const char* peer : {"ipv4:127.0.0.1:80", "ipv6:[::1]:80", "unix:/run/s", "", "fd:7"})
    EXPECT_EQ(NetworkOf(peer), "") << peer;
}

TEST(PeerAddressTest, ANetworkIsNamedByAnAddressOrAPrefix) {
  EXPECT_EQ(NetworkNamed("203.0.113.7"), "203.0.113.0/24");
  EXPECT_EQ(NetworkNamed("203.0.113.0/24"), "203.0.113.0/24");
  EXPECT_EQ(NetworkNamed("2001:DB8:0:0:1::9"), "2001:db8::/48");
  EXPECT_EQ(NetworkNamed("2001:db8:0:7::/64"), "2001:db8::/48");
  EXPECT_EQ(NetworkNamed("2001:db8::/48"), "2001:db8::/48");
  EXPECT_EQ(NetworkNamed("::ffff:203.0.113.7"), "203.0.113.0/24");
  for (const char* text : {"", "203.0.113", "203.0.113.7/16", "203.0.113.7/", "2001:db8::/32",
                           "localhost", "203.0.113.7/24/24", "2001:db8::/48x"})
    EXPECT_EQ(NetworkNamed(text), std::nullopt) << text;
}

TEST(PeerAddressTest, AProxyOnThisMachineNamesTheClient) {
  const auto forwarded = [](const char* header) {
    return ForwardedPeer("ipv4:127.0.0.1:80", header);
  };
  EXPECT_EQ(forwarded("203.0.113.7"), "ipv4:203.0.113.7:0");
  EXPECT_EQ(forwarded("198.51.100.1, 203.0.113.7 "), "ipv4:203.0.113.7:0") << "the last one";
  EXPECT_EQ(forwarded("2001:db8::9"), "ipv6:%5B2001:db8::9%5D:0");
  EXPECT_EQ(NetworkOf(forwarded("2001:db8::9")), "2001:db8::/48");
  EXPECT_EQ(forwarded("203.0.113.7:80"), "ipv4:203.0.113.7:0");
  EXPECT_EQ(forwarded("[2001:db8::9]:80"), "ipv6:%5B2001:db8::9%5D:0");
  EXPECT_EQ(forwarded(""), "ipv4:127.0.0.1:80") << "a program of this machine";
  for (const char* wrong : {",", "localhost", "203.0.113.7,", "[", "[::1"})
    EXPECT_NE(forwarded(wrong), "ipv4:127.0.0.1:80") << wrong;
  EXPECT_EQ(ForwardedPeer("ipv4:198.51.100.1:80", "203.0.113.7"), "ipv4:198.51.100.1:80")
      << "of another machine";
}

TEST(PeerAddressTest, RecognisesASocketConnectedToItsOwnAddress) {
  using boost::asio::ip::tcp;
  boost::asio::io_context io;
  const auto at = [](const char* host) {
    return tcp::endpoint(boost::asio::ip::make_address(host), 0);
  };
  tcp::acceptor acceptor(io, at("127.0.0.1"));
  const auto connects_itself = [&](const char* from) {
    tcp::socket client(io);
    client.open(tcp::v4());
    client.bind(at(from));
    client.connect(acceptor.local_endpoint());
    return ConnectsItself(acceptor.accept().native_handle());
  };
  EXPECT_TRUE(connects_itself("127.0.0.1"));
  EXPECT_FALSE(connects_itself("127.0.0.2"));
  EXPECT_FALSE(ConnectsItself(-1));
}

}  // namespace
}  // namespace sweepstake::net
