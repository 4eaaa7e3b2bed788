#include "server/tls/tls_session.h"

#include <openssl/bio.h>
#include <openssl/err.h>

#include <array>

namespace sweepstake::tls {
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
