// Derives every decision of an audit log (audit_log.h) again and compares.
//
// Each segment gets a DecisionSession of its setup row's making; each row's inputs go into it, the
// runs in the place of the frames, and the row that comes out must be the one in the log, cell by
// cell. So a difference is either an edit, or a program that decides otherwise than the one that
// wrote the log. No text makes it crash. Cost: that of the decisions (some 10 µs a row with 7
// arms), memory for one segment's session.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sweepstake::decision {

struct AuditDifference {
  uint64_t line = 0;    // of the file, from 1
  std::string session;  // empty: the text is no row
  std::string segment;
  std::string row;
  std::string column;   // empty: the row is wrong as a whole
  std::string message;  // what is wrong, in words

  // All of it in one line.
  std::string Text() const;
};

struct AuditReport {
  uint64_t session_count = 0;  // sessions, segments, rows and decisions up to the difference
  uint64_t segment_count = 0;
  uint64_t row_count = 0;
  uint64_t decision_count = 0;
  std::optional<AuditDifference> difference;  // the first; absent: everything is equal
};

// `csv` begins with the header. Segments may come in any order, each in one piece from its setup
// row on; their last rows may be missing.
AuditReport Rederive(std::string_view csv);

}  // namespace sweepstake::decision
