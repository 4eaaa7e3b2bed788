// The certificate with which a listener ends TLS. It is replaced while the daemon runs.
#pragma once

#include <openssl/ssl.h>

#include <boost/asio/ssl/context.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine_client/telemetry/tls/tls_files.h"

namespace sweepstake::tls {

// What clients and daemon speak over TLS; ALPN selects it.
enum class Protocol : uint8_t { kHttp1, kHttp2 };

// TLS 1.2 or newer.
class TlsContext {
 public:
  // With `texts.ca`, clients must have a certificate of one of these authorities. Error:
  // INVALID_ARGUMENT (OpenSSL cannot use the texts).
  static absl::StatusOr<std::shared_ptr<TlsContext>> Make(const Texts& texts, Protocol protocol);

  SSL_CTX* handle() { return context_.native_handle(); }
  boost::asio::ssl::context& context() { return context_; }

 private:
  boost::asio::ssl::context context_{boost::asio::ssl::context::tls_server};
};

// Used by one thread at a time.
class Certificate {
 public:
  // Without a certificate file, the listener uses plain text.
  Certificate(Files files, Protocol protocol) : files_(std::move(files)), protocol_(protocol) {}

  // Reads the files. If they cannot be used, the former context stays. Error: INVALID_ARGUMENT or
  // NOT_FOUND (the files cannot be used).
  absl::Status Read();
  // Returns the context for new connections; null: plain text.
  const std::shared_ptr<TlsContext>& context() const { return context_; }

 private:
  const Files files_;
  const Protocol protocol_;
  std::string texts_;  // of the context
  std::shared_ptr<TlsContext> context_;
};

}  // namespace sweepstake::tls
