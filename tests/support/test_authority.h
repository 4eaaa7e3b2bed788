// A certificate authority for tests. Keys are generated in each run, so that none is in the
// repository.
#pragma once

#include <openssl/evp.h>
#include <openssl/x509.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace sweepstake::test_support {

struct CertificateFiles {
  std::filesystem::path cert;
  std::filesystem::path key;
};

class TestAuthority {
 public:
  // Creates the authority and writes its certificate to a file.
  explicit TestAuthority(std::filesystem::path cert);

  const std::filesystem::path& cert() const { return cert_file_; }
  // Creates a key and its certificate for `host` ("IP:127.0.0.1" or "DNS:example.com") and writes
  // both to `files`, the certificate first. Each file is replaced in one step. The certificate
  // expires in `expires_in_s` seconds; a negative value makes an expired one.
  void Issue(const std::string& host, const CertificateFiles& files,
             int64_t expires_in_s = 86'400) const;

 private:
  using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;
  using Certificate = std::unique_ptr<X509, decltype(&X509_free)>;

  const std::filesystem::path cert_file_;
  Key key_;
  Certificate certificate_;
};

}  // namespace sweepstake::test_support
