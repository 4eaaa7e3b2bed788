// The files of a TLS endpoint, read and checked whole. The daemon and its clients both do this
// first, because gRPC would say of a file that it cannot use only that no connection could be made.
//
// Thread-safe. Files are PEM, of at most 1 MiB each.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace sweepstake::tls {

// An empty path means that there is no such file.
struct Files {
  std::filesystem::path cert;  // of this endpoint; the certificates of its issuers may follow it
  std::filesystem::path key;   // the private key of `cert`, without a passphrase
  std::filesystem::path ca;    // the certificates of the authorities that the other side is held to
};

// The contents of Files.
struct Texts {
  std::string cert;
  std::string key;
  std::string ca;
};

// Reads the files. Error: INVALID_ARGUMENT names the file that cannot be read, holds nothing in PEM
// form or does not belong to the other one, and says what to do. REQUIRES: `cert` and `key` are
// both given or both empty.
absl::StatusOr<Texts> Read(const Files& files);

// Returns all errors that Read could have for these files, one after the other. A certificate or a
// key without the other is checked alone.
std::vector<absl::Status> Check(const Files& files);

// Returns when the first of these certificates expires, in seconds since 1970. REQUIRES: they are
// Texts::cert that Read has returned.
int64_t EarliestExpiryUnixS(const std::string& certificates);

}  // namespace sweepstake::tls
