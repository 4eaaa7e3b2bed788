// Tests the HTTP listener with TLS, over real sockets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "server/web/http_server.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/test_authority.h"

namespace sweepstake::web {
namespace {

namespace ssl = boost::asio::ssl;
using boost::asio::ip::tcp;
using test_support::CertificateFiles;
using test_support::TestAuthority;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class HttpsTest : public ::testing::Test {
 protected:
  HttpsTest() { authority_.Issue("IP:127.0.0.1", files_); }

  std::unique_ptr<HttpServer> Start() {
    const auto make = [](boost::asio::io_context& /*io*/) -> Handler {
      return [](const std::shared_ptr<Exchange>& exchange) {
        exchange->Answer({.body = exchange->request().is_tls ? "over TLS" : "in plain text"});
      };
    };
    auto server =
        HttpServer::Start("127.0.0.1:0", make, {.cert = files_.cert, .key = files_.key, .ca = {}});
    EXPECT_TRUE(server.ok()) << server.status();
    return *std::move(server);
  }

  // Returns the answer to a GET, or the error of the handshake.
  static std::string Get(int port, const TestAuthority& trusted, const std::string& alpn = "") {
    ssl::context context(ssl::context::tls_client);
    context.load_verify_file(trusted.cert());
    context.set_verify_mode(ssl::verify_peer);
    boost::asio::io_context io;
    ssl::stream<tcp::socket> stream(io, context);
    if (!alpn.empty()) {
      const std::string offered = static_cast<char>(alpn.size()) + alpn;
      SSL_set_alpn_protos(stream.native_handle(),
                          reinterpret_cast<const unsigned char*>(offered.data()),
                          static_cast<unsigned>(offered.size()));
    }
    stream.next_layer().connect(
        {boost::asio::ip::make_address("127.0.0.1"), static_cast<uint16_t>(port)});
    boost::system::error_code error;
    stream.handshake(ssl::stream_base::client, error);
    if (error) return error.message();
    const std::string request = "GET / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";
    boost::asio::write(stream, boost::asio::buffer(request));
    std::string answer;
    boost::asio::read(stream, boost::asio::dynamic_buffer(answer), error);
    return answer;
  }

  const test_support::TemporaryDirectory folder_;
  const TestAuthority authority_{folder_.path() / "ca.pem"};
  const TestAuthority other_{folder_.path() / "other.pem"};
  const CertificateFiles files_{folder_.path() / "cert.pem", folder_.path() / "key.pem"};
};

TEST_F(HttpsTest, AnswersOverTlsOnly) {
  const auto server = Start();
  const std::string answer = Get(server->port(), authority_, "http/1.1");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr("over TLS"));
  EXPECT_THAT(Get(server->port(), authority_), HasSubstr("over TLS"));
  EXPECT_THAT(Get(server->port(), authority_, "http/1.0"), HasSubstr("over TLS"));
  EXPECT_THAT(Get(server->port(), authority_, "h2"), HasSubstr("alert no application protocol"));
  test_support::HttpSocket plain(server->port());
  plain.Send("GET / HTTP/1.1\r\n\r\n");
  EXPECT_EQ(plain.ReadAll().find("plain text"), std::string::npos);
}

TEST_F(HttpsTest, NewConnectionsUseAReplacedCertificate) {
  const auto server = Start();
  EXPECT_THAT(Get(server->port(), other_), HasSubstr("certificate verify failed"));
  other_.Issue("IP:127.0.0.1", files_);
  std::string answer;
  for (int attempt = 0; attempt < 600 && !answer.starts_with("HTTP/1.1 200"); ++attempt) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    answer = Get(server->port(), other_);
  }
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
}

TEST_F(HttpsTest, UnusableFilesAreAnError) {
  const auto make = [](boost::asio::io_context& /*io*/) { return Handler(); };
  const auto server =
      HttpServer::Start("127.0.0.1:0", make, {.cert = "nowhere", .key = "nowhere", .ca = {}});
  EXPECT_FALSE(server.ok());
}

}  // namespace
}  // namespace sweepstake::web
