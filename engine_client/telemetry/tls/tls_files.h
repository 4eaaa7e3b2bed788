// Reads and checks the files of a TLS endpoint, and decides which addresses need TLS. The daemon
// and its clients share these rules. The files are checked before gRPC gets them, because gRPC
// reports an unusable file only as a failed connection.
//
// Thread-safe. Files are in PEM format and have at most 1 MiB each.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace sweepstake::tls {

// The paths of the files. An empty path means that the file is not used.
struct Files {
  // The certificate of this endpoint, optionally followed by the certificates of its issuers.
  std::filesystem::path cert;
  std::filesystem::path key;  // the private key of `cert`, without a passphrase
  // The certificates of the authorities that must have signed the other side's certificate.
  std::filesystem::path ca;
};

// The contents of the files in Files.
struct Texts {
  std::string cert;
  std::string key;
  std::string ca;
};

// Reads the files. Returns INVALID_ARGUMENT if a file cannot be read, if it contains nothing in PEM
// format, or if key and certificate do not match. The message names the file and the correction.
// REQUIRES: `cert` and `key` are both set or both empty.
absl::StatusOr<Texts> Read(const Files& files);

// Returns all errors of these files; Read returns only the first one. If only one of `cert` and
// `key` is set, it is checked alone.
std::vector<absl::Status> Check(const Files& files);

// Returns the earliest time at which one of these certificates expires, in seconds since 1970.
// REQUIRES: `certificates` is the Texts::cert of a successful Read.
int64_t EarliestExpiryUnixS(const std::string& certificates);

// Returns whether HOST:PORT is on this machine: a numeric loopback address, or the name localhost.
// Other names are not resolved, because the next call could resolve them to another machine. Even a
// name that begins with "127." can belong to another machine.
bool IsLoopback(const std::string& address);

}  // namespace sweepstake::tls
