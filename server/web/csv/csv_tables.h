// The tables that the daemon writes as CSV. Each is made from the responses of one method of the
// API, so that its permissions and limits are those of the method. Headers contain the units.
#pragma once

#include <google/protobuf/message.h>

#include <memory>
#include <string>
#include <string_view>

namespace sweepstake::web {

// Writes one table. Not thread-safe.
class CsvTable {
 public:
  virtual ~CsvTable() = default;
  // Returns the first line, which has the names of the columns.
  virtual std::string Header() const = 0;
  // Returns the lines of the next response. REQUIRES: it is a response of the table's method.
  virtual std::string Lines(const google::protobuf::Message& response) = 0;
};

struct CsvKind {
  std::string_view name;    // the last part of the path, such as "decisions"
  std::string_view method;  // "sweepstake.v1.SERVICE/METHOD"
  std::unique_ptr<CsvTable> (*make)();
};

// Returns the table of this name, or null.
const CsvKind* FindCsv(std::string_view name);

}  // namespace sweepstake::web
