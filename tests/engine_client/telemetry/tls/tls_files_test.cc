// Tests TLS files: the content of valid files, and the errors for invalid files.
#include "engine_client/telemetry/tls/tls_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>

#include <cstdio>
#include <fstream>
#include <iterator>

#include "tests/support/temporary_directory.h"
#include "tests/support/test_authority.h"

namespace sweepstake::tls {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string ReadText(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

class TlsFilesTest : public ::testing::Test {
 protected:
  TlsFilesTest() { authority_.Issue("IP:127.0.0.1", {files_.cert, files_.key}); }
  // gRPC's handshakes use the same error queue, so it must be empty.
  ~TlsFilesTest() override { EXPECT_EQ(ERR_peek_error(), 0u); }

  std::filesystem::path Path(const std::string& name) const { return folder_.path() / name; }
  std::filesystem::path Write(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name)) << text;
    return Path(name);
  }
  std::string Error() const { return std::string(Read(files_).status().message()); }

  test_support::TemporaryDirectory folder_;
  test_support::TestAuthority authority_{Path("ca.pem")};
  Files files_{.cert = Path("cert.pem"), .key = Path("key.pem"), .ca = authority_.cert()};
};

TEST_F(TlsFilesTest, ReadsValidFiles) {
  const auto texts = Read(files_);
  ASSERT_TRUE(texts.ok()) << texts.status();
  EXPECT_EQ(texts->cert, ReadText(files_.cert));
  EXPECT_EQ(texts->key, ReadText(files_.key));
  EXPECT_EQ(texts->ca, ReadText(files_.ca));
  EXPECT_EQ(Read({})->ca, "");
}

TEST_F(TlsFilesTest, IssuersMayFollowTheCertificate) {
  files_.cert = Write("chain.pem", ReadText(files_.cert) + "\n" + ReadText(authority_.cert()));
  EXPECT_TRUE(Read(files_).ok()) << Error();
  files_.cert = Write("upside-down.pem", ReadText(authority_.cert()) + ReadText(Path("cert.pem")));
  EXPECT_THAT(Error(), HasSubstr("key values mismatch"));
}

TEST_F(TlsFilesTest, ErrorsNameTheUnreadableFileAndTheReason) {
  files_.key = Path("nowhere.pem");
  EXPECT_THAT(Error(), AllOf(HasSubstr("cannot read " + files_.key.string()),
                             HasSubstr("No such file"), HasSubstr("name a PEM file")));
  files_.key = folder_.path();
  EXPECT_THAT(Error(), HasSubstr("Is a directory"));
  files_.key = Write("large.pem", std::string((1 << 20) + 1, 'x'));
  EXPECT_THAT(Error(), HasSubstr("too large"));
}

TEST_F(TlsFilesTest, CheckReportsAllErrorsAtOnce) {
  EXPECT_TRUE(Check(files_).empty());
  const Files missing{.cert = Path("a.pem"), .key = Path("b.pem"), .ca = Path("c.pem")};
  EXPECT_EQ(Check(missing).size(), 3u);
  const Files wrong{.cert = Write("text.pem", "hello"), .key = files_.key, .ca = Path("text.pem")};
  EXPECT_EQ(Check(wrong).size(), 2u);
  EXPECT_EQ(Check({.cert = Path("a.pem"), .key = {}, .ca = {}}).size(), 1u);
  EXPECT_EQ(Check({.cert = Path("text.pem"), .key = {}, .ca = {}}).size(), 1u);
  EXPECT_TRUE(Check({.cert = files_.cert, .key = {}, .ca = {}}).empty());
}

TEST_F(TlsFilesTest, RefusesAKeyOfAnotherCertificate) {
  authority_.Issue("IP:127.0.0.1", {Path("other-cert.pem"), Path("other-key.pem")});
  files_.key = Path("other-key.pem");
  EXPECT_THAT(Error(), AllOf(HasSubstr(files_.cert.string()), HasSubstr(files_.key.string()),
                             HasSubstr("key values mismatch")));
}

TEST_F(TlsFilesTest, RefusesIncompleteCertificates) {
  const std::string whole = ReadText(files_.cert);
  for (const std::string& text :
       {std::string("hello"), std::string(), whole.substr(0, whole.size() / 2),
        whole + whole.substr(0, whole.size() / 2), ReadText(files_.key)}) {
    Files changed = files_;
    changed.cert = Write("changed.pem", text);
    EXPECT_THAT(std::string(Read(changed).status().message()),
                HasSubstr("changed.pem contains no complete certificate in PEM format"))
        << text;
    changed = files_;
    changed.ca = Path("changed.pem");
    EXPECT_THAT(std::string(Read(changed).status().message()), HasSubstr("changed.pem"));
  }
}

TEST_F(TlsFilesTest, RefusesAnEncryptedKeyWithoutAskingForThePassphrase) {
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(EVP_EC_gen("P-256"),
                                                                &EVP_PKEY_free);
  files_.key = Path("locked.pem");
  FILE* file = std::fopen(files_.key.c_str(), "w");
  char passphrase[] = "secret";
  ASSERT_EQ(PEM_write_PKCS8PrivateKey(file, key.get(), EVP_aes_256_cbc(), passphrase,
                                      sizeof passphrase - 1, nullptr, nullptr),
            1);
  std::fclose(file);
  EXPECT_THAT(Error(), HasSubstr("contains no unencrypted private key in PEM format"));
}

}  // namespace
}  // namespace sweepstake::tls
