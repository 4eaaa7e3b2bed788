// Reads and checks the files of a TLS endpoint, and decides which addresses need TLS. The daemon
// and its clients share these rules. They check the files before they use gRPC, which reports an
// unusable file only as a failed connection.
//
// Thread-safe. Files are in PEM format and have at most 1 MiB each.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace sweepstake::tls {

// An empty path means that there is no such file.
struct Files {
  // The certificate of this endpoint, optionally followed by those of its issuers.
  std::filesystem::path cert;
  std::filesystem::path key;  // the private key of `cert`, without a passphrase
  // The certificates of the authorities that must have signed the other side's certificate.
  std::filesystem::path ca;
};

// The contents of Files.
struct Texts {
  std::string cert;
  std::string key;
  std::string ca;
};

// Reads the files. Error: INVALID_ARGUMENT if a file cannot be read, contains nothing in PEM
// format, or if key and certificate do not match. The message names the file and says what to do.
// REQUIRES: `cert` and `key` are both set or both empty.
absl::StatusOr<Texts> Read(const Files& files);

// Returns all errors of these files; Read returns only the first one. A certificate or a key
// without the other is checked alone.
std::vector<absl::Status> Check(const Files& files);

// Returns the earliest time at which one of these certificates expires, in seconds since 1970.
// REQUIRES: `certificates` is the Texts::cert of a successful Read.
int64_t EarliestExpiryUnixS(const std::string& certificates);

// Returns whether HOST:PORT is on the same machine: a numeric loopback address, or localhost. Other
// names are not resolved, because they may resolve to another machine at the next call. Even a name
// that begins with "127." may belong to another machine.
bool IsLoopback(const std::string& address);

}  // namespace sweepstake::tls
