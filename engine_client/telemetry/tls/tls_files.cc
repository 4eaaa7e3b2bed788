#include "engine_client/telemetry/tls/tls_files.h"

#include <arpa/inet.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"

namespace sweepstake::tls {
namespace {

constexpr uintmax_t kMaxFileBytes = 1 << 20;

template <auto Free>
struct Freer {
  template <typename T>
  void operator()(T* object) const {
    Free(object);
  }
};
using Bio = std::unique_ptr<BIO, Freer<BIO_free>>;
using Certificate = std::unique_ptr<X509, Freer<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freer<EVP_PKEY_free>>;
using Context = std::unique_ptr<SSL_CTX, Freer<SSL_CTX_free>>;

Bio Reader(const std::string& text) {
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

// Returns the oldest error in this thread's OpenSSL queue, and clears the queue. gRPC's handshakes
// read the same queue, so no error must remain in it.
std::string TakeError() {
  const char* reason = ERR_reason_error_string(ERR_peek_error());
  ERR_clear_error();
  return reason == nullptr ? "unknown error" : reason;
}

absl::StatusOr<std::string> ReadFile(const std::filesystem::path& path) {
  if (path.empty()) return std::string();
  std::error_code error;
  const uintmax_t size = std::filesystem::file_size(path, error);  // fails unless it is a file
  if (!error && size > kMaxFileBytes) error = std::make_error_code(std::errc::file_too_large);
  std::ifstream file(path, std::ios::binary);
  if (!error && !file) error = std::error_code(errno, std::generic_category());
  if (!error) return std::string(std::istreambuf_iterator<char>(file), {});
  return absl::InvalidArgumentError(absl::StrCat("cannot read ", path.string(), ": ",
                                                 error.message(),
                                                 "; name a PEM file that this user can read"));
}

// Returns the first certificate in `text`. Returns null if there is none, or if any certificate in
// it cannot be parsed.
Certificate FirstCertificate(const std::string& text) {
  const Bio reader = Reader(text);
  Certificate first;
  while (Certificate next{PEM_read_bio_X509(reader.get(), nullptr, nullptr, nullptr)}) {
    if (first == nullptr) first = std::move(next);
  }
  // PEM_R_NO_START_LINE means that the end of the text was reached. A truncated certificate gives
  // another error.
  if (ERR_GET_REASON(ERR_peek_last_error()) != PEM_R_NO_START_LINE) first.reset();
  ERR_clear_error();
  return first;
}

absl::Status NoCertificate(const std::filesystem::path& path) {
  return absl::InvalidArgumentError(
      absl::StrCat(path.string(), " contains no complete certificate in PEM format"));
}

// Makes OpenSSL fail on an encrypted key. Without this callback OpenSSL would read the passphrase
// from the terminal and block a service.
int NoPassphrase(char* /*buffer*/, int /*size*/, int /*writing*/, void* /*data*/) { return -1; }

absl::Status CheckPair(const Files& files, const Texts& texts) {
  const Certificate certificate = FirstCertificate(texts.cert);
  if (certificate == nullptr) return NoCertificate(files.cert);
  if (files.key.empty()) return absl::OkStatus();
  const Key key(PEM_read_bio_PrivateKey(Reader(texts.key).get(), nullptr, NoPassphrase, nullptr));
  ERR_clear_error();
  if (key == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(files.key.string(),
                     " contains no unencrypted private key in PEM format; remove its passphrase or "
                     "name another file"));
  }
  const Context context(SSL_CTX_new(TLS_method()));
  if (context != nullptr && SSL_CTX_use_certificate(context.get(), certificate.get()) == 1 &&
      SSL_CTX_use_PrivateKey(context.get(), key.get()) == 1) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "the certificate ", files.cert.string(), " and the key ", files.key.string(),
      " cannot be used together (", TakeError(), "); name the key of this certificate"));
}

// Returns the contents of the files that can be read. Adds an error for each file that cannot be
// read or has invalid content.
Texts ReadAll(const Files& files, std::vector<absl::Status>& problems) {
  const auto add = [&](absl::Status status) {
    const bool is_ok = status.ok();
    if (!is_ok) problems.push_back(std::move(status));
    return is_ok;
  };
  Texts texts;
  const auto read = [&](const std::filesystem::path& path, std::string& text) {
    absl::StatusOr<std::string> whole = ReadFile(path);
    const bool is_read = add(whole.status());
    if (is_read) text = *std::move(whole);
    return is_read && !path.empty();
  };
  const bool has_cert = read(files.cert, texts.cert);
  const bool has_key = read(files.key, texts.key) || files.key.empty();
  const bool has_ca = read(files.ca, texts.ca);
  if (has_cert && has_key) add(CheckPair(files, texts));
  if (has_ca && FirstCertificate(texts.ca) == nullptr) add(NoCertificate(files.ca));
  return texts;
}

}  // namespace

absl::StatusOr<Texts> Read(const Files& files) {
  std::vector<absl::Status> problems;
  Texts texts = ReadAll(files, problems);
  if (!problems.empty()) return problems.front();
  return texts;
}

std::vector<absl::Status> Check(const Files& files) {
  std::vector<absl::Status> problems;
  ReadAll(files, problems);
  return problems;
}

int64_t EarliestExpiryUnixS(const std::string& certificates) {
  const Bio reader = Reader(certificates);
  int64_t earliest = std::numeric_limits<int64_t>::max();
  while (const Certificate next{PEM_read_bio_X509(reader.get(), nullptr, nullptr, nullptr)}) {
    std::tm end{};
    if (ASN1_TIME_to_tm(X509_get0_notAfter(next.get()), &end) == 1)
      earliest = std::min<int64_t>(earliest, timegm(&end));
  }
  ERR_clear_error();
  return earliest;
}

bool IsLoopback(const std::string& address) {
  const std::string host = address.substr(0, address.rfind(':'));
  in_addr number{};
  const bool is_number = inet_pton(AF_INET, host.c_str(), &number) == 1;
  return host == "localhost" || host == "[::1]" || (is_number && ntohl(number.s_addr) >> 24 == 127);
}

}  // namespace sweepstake::tls
