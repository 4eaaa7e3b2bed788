#include "tests/support/test_authority.h"

#include <openssl/ec.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <utility>

namespace sweepstake::test_support {
namespace {

void Check(bool succeeded, const char* what) {
  if (succeeded) return;
  std::fprintf(stderr, "TestAuthority: cannot %s\n", what);
  std::abort();
}

void AddExtension(X509* certificate, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, certificate, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str());
  Check(extension != nullptr && X509_add_ext(certificate, extension, -1) == 1, "add an extension");
  X509_EXTENSION_free(extension);
}

// Creates a certificate of `key`, not signed yet, with a unique name and serial number.
X509* MakeCertificate(EVP_PKEY* key) {
  X509* certificate = X509_new();
  uint32_t number = 0;
  Check(RAND_bytes(reinterpret_cast<unsigned char*>(&number), sizeof number) == 1, "draw a number");
  X509_set_version(certificate, X509_VERSION_3);
  ASN1_INTEGER_set(X509_get_serialNumber(certificate), number);
  X509_gmtime_adj(X509_getm_notBefore(certificate), -86'400);
  X509_gmtime_adj(X509_getm_notAfter(certificate), 86'400);
  const std::string name = "sweepstake test " + std::to_string(number);
  X509_NAME_add_entry_by_txt(X509_get_subject_name(certificate), "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
  X509_set_pubkey(certificate, key);
  return certificate;
}

void WriteFile(const std::filesystem::path& path, const std::function<bool(FILE*)>& write) {
  const std::filesystem::path unfinished = path.string() + ".new";
  FILE* file = std::fopen(unfinished.c_str(), "w");
  Check(file != nullptr && write(file) && std::fclose(file) == 0, "write a file");
  std::filesystem::rename(unfinished, path);
}

}  // namespace

TestAuthority::TestAuthority(std::filesystem::path cert)
    : cert_file_(std::move(cert)),
      key_(EVP_EC_gen("P-256"), &EVP_PKEY_free),
      certificate_(MakeCertificate(key_.get()), &X509_free) {
  X509_set_issuer_name(certificate_.get(), X509_get_subject_name(certificate_.get()));
  AddExtension(certificate_.get(), NID_basic_constraints, "critical,CA:TRUE");
  Check(X509_sign(certificate_.get(), key_.get(), EVP_sha256()) > 0, "sign the authority");
  WriteFile(cert_file_, [&](FILE* file) { return PEM_write_X509(file, certificate_.get()) == 1; });
}

void TestAuthority::Issue(const std::string& host, const CertificateFiles& files,
                          int64_t expires_in_s) const {
  const Key key(EVP_EC_gen("P-256"), &EVP_PKEY_free);
  const Certificate certificate(MakeCertificate(key.get()), &X509_free);
  X509_set_issuer_name(certificate.get(), X509_get_subject_name(certificate_.get()));
  X509_gmtime_adj(X509_getm_notAfter(certificate.get()), expires_in_s);
  AddExtension(certificate.get(), NID_subject_alt_name, host);
  Check(X509_sign(certificate.get(), key_.get(), EVP_sha256()) > 0, "sign a certificate");
  WriteFile(files.cert, [&](FILE* file) { return PEM_write_X509(file, certificate.get()) == 1; });
  WriteFile(files.key, [&](FILE* file) {
    return PEM_write_PrivateKey(file, key.get(), nullptr, nullptr, 0, nullptr, nullptr) == 1;
  });
}

}  // namespace sweepstake::test_support
