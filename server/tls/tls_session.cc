#include "server/tls/tls_session.h"

#include <openssl/bio.h>
#include <openssl/err.h>

#include <array>
#include <boost/asio/buffer.hpp>

#include "absl/strings/str_cat.h"

namespace sweepstake::tls {
namespace {

namespace ssl = boost::asio::ssl;

constexpr std::array<unsigned char, 3> kHttp2 = {2, 'h', '2'};

int SelectHttp2(SSL* /*session*/, const unsigned char** chosen, unsigned char* chosen_size,
                const unsigned char* offered, unsigned int offered_size, void* /*unused*/) {
  unsigned char* selected = nullptr;
  const int result = SSL_select_next_proto(&selected, chosen_size, kHttp2.data(), kHttp2.size(),
                                           offered, offered_size);
  *chosen = selected;
  return result == OPENSSL_NPN_NEGOTIATED ? SSL_TLSEXT_ERR_OK : SSL_TLSEXT_ERR_ALERT_FATAL;
}

}  // namespace

absl::StatusOr<std::shared_ptr<TlsContext>> TlsContext::Make(const Texts& texts) {
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
  SSL_CTX_set_options(handle, SSL_OP_NO_RENEGOTIATION);
  SSL_CTX_set_session_cache_mode(handle, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_mode(handle, SSL_MODE_RELEASE_BUFFERS);
  SSL_CTX_set_alpn_select_cb(handle, SelectHttp2, nullptr);
  return made;
}

TlsSession::TlsSession(const std::shared_ptr<TlsContext>& context)
    : context_(context),
      ssl_(SSL_new(context->handle())),
      input_(BIO_new(BIO_s_mem())),
      output_(BIO_new(BIO_s_mem())) {
  SSL_set_bio(ssl_.get(), input_, output_);
  SSL_set_accept_state(ssl_.get());
}

bool TlsSession::FromClient(std::string_view bytes, std::string& plain, std::string& to_client) {
  ERR_clear_error();
  BIO_write(input_, bytes.data(), static_cast<int>(bytes.size()));
  std::array<char, 16 * 1024> buffer;
  int count = 0;
  while ((count = SSL_read(ssl_.get(), buffer.data(), static_cast<int>(buffer.size()))) > 0)
    plain.append(buffer.data(), static_cast<size_t>(count));
  const bool is_open = SSL_get_error(ssl_.get(), count) == SSL_ERROR_WANT_READ;
  if (is_open && SSL_is_init_finished(ssl_.get()) && !waiting_.empty())
    return ToClient({}, to_client);
  TakeOutput(to_client);
  return is_open;
}

bool TlsSession::ToClient(std::string_view plain, std::string& to_client) {
  waiting_ += plain;
  if (!SSL_is_init_finished(ssl_.get()) || waiting_.empty()) return true;
  ERR_clear_error();
  // A memory BIO takes all bytes.
  const int written = SSL_write(ssl_.get(), waiting_.data(), static_cast<int>(waiting_.size()));
  waiting_.clear();
  waiting_.shrink_to_fit();
  TakeOutput(to_client);
  return written > 0;
}

void TlsSession::TakeOutput(std::string& to_client) {
  const size_t count = BIO_ctrl_pending(output_);
  const size_t before = to_client.size();
  to_client.resize(before + count);
  if (count > 0) BIO_read(output_, to_client.data() + before, static_cast<int>(count));
}

}  // namespace sweepstake::tls
