#include "server/web/api/token_seal.h"

#include <openssl/evp.h>
#include <openssl/sha.h>

#include <array>
#include <cstdlib>
#include <memory>

namespace sweepstake::web {
namespace {

constexpr size_t kTagBytes = 16;
// A key seals one text, so that its nonce need not differ from another's.
constexpr std::array<unsigned char, 12> kNonce{};
// The key is no digest that something else is found by.
constexpr std::string_view kPurpose = "sweepstake login: ";

using Key = std::array<unsigned char, SHA256_DIGEST_LENGTH>;

struct CipherDeleter {
  void operator()(EVP_CIPHER_CTX* cipher) const { EVP_CIPHER_CTX_free(cipher); }
};
using Cipher = std::unique_ptr<EVP_CIPHER_CTX, CipherDeleter>;

const unsigned char* BytesOf(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}
unsigned char* BytesOf(std::string& text) { return reinterpret_cast<unsigned char*>(text.data()); }

Key KeyOf(std::string_view cookie) {
  const std::string text = std::string(kPurpose).append(cookie);
  Key key;
  SHA256(BytesOf(text), text.size(), key.data());
  return key;
}

}  // namespace

std::string SealToken(std::string_view cookie, std::string_view token) {
  const Cipher cipher(EVP_CIPHER_CTX_new());
  std::string sealed(token.size() + kTagBytes, '\0');
  int written = 0;
  const auto size = static_cast<int>(token.size());
  // It fails for want of memory alone.
  if (!cipher ||
      EVP_EncryptInit_ex(cipher.get(), EVP_aes_256_gcm(), nullptr, KeyOf(cookie).data(),
                         kNonce.data()) != 1 ||
      EVP_EncryptUpdate(cipher.get(), BytesOf(sealed), &written, BytesOf(token), size) != 1 ||
      EVP_EncryptFinal_ex(cipher.get(), BytesOf(sealed) + written, &written) != 1 ||
      EVP_CIPHER_CTX_ctrl(cipher.get(), EVP_CTRL_GCM_GET_TAG, kTagBytes,
                          BytesOf(sealed) + token.size()) != 1) {
    std::abort();
  }
  return sealed;
}

std::optional<std::string> OpenToken(std::string_view cookie, std::string_view sealed) {
  if (sealed.size() < kTagBytes) return std::nullopt;
  const Cipher cipher(EVP_CIPHER_CTX_new());
  std::string tag(sealed.substr(sealed.size() - kTagBytes));
  sealed.remove_suffix(kTagBytes);
  std::string token(sealed.size(), '\0');
  int written = 0;
  const auto size = static_cast<int>(sealed.size());
  if (!cipher ||
      EVP_DecryptInit_ex(cipher.get(), EVP_aes_256_gcm(), nullptr, KeyOf(cookie).data(),
                         kNonce.data()) != 1 ||
      EVP_DecryptUpdate(cipher.get(), BytesOf(token), &written, BytesOf(sealed), size) != 1 ||
      EVP_CIPHER_CTX_ctrl(cipher.get(), EVP_CTRL_GCM_SET_TAG, kTagBytes, tag.data()) != 1 ||
      EVP_DecryptFinal_ex(cipher.get(), BytesOf(token) + written, &written) != 1) {
    return std::nullopt;
  }
  return token;
}

}  // namespace sweepstake::web
