#include "server/tls/certificate.h"

#include <string_view>

#include <boost/asio/buffer.hpp>

#include "absl/strings/str_cat.h"

namespace sweepstake::tls {
namespace {

namespace ssl = boost::asio::ssl;

// Protocols in the format of ALPN (RFC 7301): each has its length before it.
constexpr std::string_view kNames[] = {"\x08http/1.1\x08http/1.0", "\x02h2"};

int Select(SSL* /*session*/, const unsigned char** chosen, unsigned char* chosen_size,
           const unsigned char* offered, unsigned int offered_size, void* protocol) {
  const std::string_view name = *static_cast<const std::string_view*>(protocol);
  unsigned char* selected = nullptr;
  const int result = SSL_select_next_proto(
      &selected, chosen_size, reinterpret_cast<const unsigned char*>(name.data()),
      static_cast<unsigned>(name.size()), offered, offered_size);
  *chosen = selected;
  return result == OPENSSL_NPN_NEGOTIATED ? SSL_TLSEXT_ERR_OK : SSL_TLSEXT_ERR_ALERT_FATAL;
}

}  // namespace

absl::StatusOr<std::shared_ptr<TlsContext>> TlsContext::Make(const Texts& texts,
                                                             Protocol protocol) {
  auto made = std::make_shared<TlsContext>();
  boost::system::error_code error;
  ssl::context& context = made->context_;
  context.use_certificate_chain(boost::asio::buffer(texts.cert), error);
  if (!error) context.use_private_key(boost::asio::buffer(texts.key), ssl::context::pem, error);
  if (!error && !texts.ca.empty()) {
    context.add_certificate_authority(boost::asio::buffer(texts.ca), error);
    context.set_verify_mode(ssl::verify_peer | ssl::verify_fail_if_no_peer_cert);
  }
  if (error)
    return absl::InvalidArgumentError(
        absl::StrCat("the TLS files are unusable: ", error.message()));
  SSL_CTX* handle = made->handle();
  SSL_CTX_set_min_proto_version(handle, TLS1_2_VERSION);
  SSL_CTX_set_options(handle, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_TICKET);
  SSL_CTX_set_num_tickets(handle, 0);  // sessions of clients with certificates cannot be resumed
  SSL_CTX_set_session_cache_mode(handle, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_mode(handle, SSL_MODE_RELEASE_BUFFERS);
  SSL_CTX_set_alpn_select_cb(handle, Select,
                             const_cast<std::string_view*>(&kNames[static_cast<size_t>(protocol)]));
  return made;
}

absl::Status Certificate::Read() {
  if (files_.cert.empty()) return absl::OkStatus();
  const auto texts = tls::Read(files_);
  if (!texts.ok()) return texts.status();
  std::string all = absl::StrCat(texts->cert, texts->key, texts->ca);
  if (all == texts_) return absl::OkStatus();
  auto context = TlsContext::Make(*texts, protocol_);
  if (!context.ok()) return context.status();
  context_ = *std::move(context);
  texts_ = std::move(all);
  return absl::OkStatus();
}

}  // namespace sweepstake::tls
