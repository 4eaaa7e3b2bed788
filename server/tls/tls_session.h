// Ends TLS in the daemon, so that it can read what clients send before gRPC does.
//
// A TlsSession converts the bytes of one connection. It does not use sockets.
#pragma once

#include <openssl/ssl.h>

#include <memory>
#include <string>
#include <string_view>

#include "server/tls/certificate.h"

namespace sweepstake::tls {

// One thread at a time.
class TlsSession {
 public:
  explicit TlsSession(const std::shared_ptr<TlsContext>& context);

  // Takes bytes of the client. Appends the decrypted bytes to `plain`, and what the client must
  // read to `to_client`. Returns false if the session has ended or failed; `to_client` may then
  // have an alert.
  bool FromClient(std::string_view bytes, std::string& plain, std::string& to_client);
  // Encrypts bytes for the client. Before the end of the handshake they wait in this object.
  // Returns false if the session has failed.
  bool ToClient(std::string_view plain, std::string& to_client);

 private:
  struct Free {
    void operator()(SSL* ssl) const { SSL_free(ssl); }
  };
  void TakeOutput(std::string& to_client);

  std::shared_ptr<TlsContext> context_;
  std::unique_ptr<SSL, Free> ssl_;
  BIO* input_;   // owned by ssl_
  BIO* output_;  // owned by ssl_
  std::string waiting_;
};

}  // namespace sweepstake::tls
