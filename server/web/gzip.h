// Compresses answers with gzip (RFC 1952), for clients that accept it. Only a page of this daemon
// can send requests with a user's cookie, so that no other page can learn secrets from the sizes of
// compressed answers (the BREACH attack).
#pragma once

#include <zlib.h>

#include <string>
#include <string_view>

#include "server/web/http_message.h"

namespace sweepstake::web {

// Returns whether the client accepts gzip.
bool AcceptsGzip(const Request& request);
// Returns whether texts of this type become smaller.
bool IsCompressible(std::string_view content_type);

// Compresses one answer, part by part. Uses about 130 kB of memory. Not thread-safe.
class GzipWriter {
 public:
  GzipWriter();
  ~GzipWriter() { deflateEnd(&stream_); }
  GzipWriter(const GzipWriter&) = delete;
  GzipWriter& operator=(const GzipWriter&) = delete;

  // Compresses the next part. The client can decompress each part at once. With `is_last`, also
  // ends the answer.
  std::string Write(std::string_view part, bool is_last);

 private:
  z_stream stream_ = {};
};

// Compresses the body of a page in place, unless it is small, compressed or of another type.
void Compress(Page& page);

}  // namespace sweepstake::web
