// Saves a ProxySet as a snapshot and restores it. A snapshot consists of a header and all fields
// that results depend on.
#include <string>

#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/broad_phase/proxies/proxy_set_impl.h"
#include "engine_client/broad_phase/proxies/snapshot.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {
namespace {

// The version of the format. Increment it when the fields or their order change.
constexpr uint32_t kSnapshotVersion = 3;
// "SWPS" in the byte order of the machine that wrote it.
constexpr uint32_t kMagic = 0x53505753;

struct Header {
  uint32_t magic = kMagic;
  uint32_t version = kSnapshotVersion;
  uint64_t bytes = 0;     // the size of the whole snapshot
  uint64_t checksum = 0;  // the checksum of everything behind the header
  uint32_t options = 0;   // OptionBits of the saved set
  float event_margin = 0;
};
static_assert(sizeof(Header) == 32);

uint32_t OptionBits(const ProxySetOptions& options) {
  return (options.sorted_pairs ? 1U : 0U) | (options.pair_events ? 2U : 0U);
}

Status Damaged(const std::string& what) {
  return {StatusCode::kDataLoss, "the snapshot " + what + "; the proxies are unchanged"};
}

// Checks the header, the size and the checksum before any field is read.
Status CheckHeader(std::span<const std::byte> snapshot, const ProxySetOptions& options) {
  Header header;
  if (snapshot.size() < sizeof header) return Damaged("is shorter than its header");
  std::memcpy(&header, snapshot.data(), sizeof header);
  if (header.magic != kMagic)
    return Damaged("was not saved by a ProxySet on a machine of this byte order");
  if (header.version != kSnapshotVersion) {
    return {StatusCode::kInvalidArgument,
            "the snapshot has version " + std::to_string(header.version) +
                ", but this library reads version " + std::to_string(kSnapshotVersion)};
  }
  if (header.bytes < sizeof header || header.bytes > snapshot.size()) {
    return Damaged("has " + std::to_string(snapshot.size()) + " of " +
                   std::to_string(header.bytes) + " bytes");
  }
  if (header.checksum != Checksum(snapshot.first(header.bytes).subspan(sizeof header))) {
    return Damaged("is damaged");
  }
  if (header.options != OptionBits(options) || header.event_margin != options.event_margin) {
    return {StatusCode::kInvalidArgument,
            "the snapshot was saved with other options: sorted_pairs, pair_events and "
            "event_margin must be the same"};
  }
  return {};
}

}  // namespace

template <typename Self, typename Archive>
void ProxySet::Impl::Visit(Self& self, Archive& archive) {
  ProxyKind::Visit(self.moving_, archive);
  ProxyKind::Visit(self.resting_, archive);
  archive.Value(self.groups_);
  PopulationJoins::Visit(self.joins_, archive);
  PairEvents::Visit(self.events_, archive);
}

size_t ProxySet::Impl::snapshot_bytes() const {
  SnapshotSizer sizer;
  Visit(*this, sizer);
  return sizeof(Header) + sizer.bytes();
}

Status ProxySet::Impl::Save(std::span<std::byte> snapshot) const {
  Header header;
  header.bytes = snapshot_bytes();
  if (snapshot.size() < header.bytes) {
    return {StatusCode::kInvalidArgument, "the snapshot needs " + std::to_string(header.bytes) +
                                              " bytes, but the buffer has only " +
                                              std::to_string(snapshot.size())};
  }
  SnapshotWriter writer(snapshot.data() + sizeof header);
  Visit(*this, writer);
  header.checksum = Checksum(snapshot.first(header.bytes).subspan(sizeof header));
  header.options = OptionBits(options_);
  header.event_margin = options_.event_margin;
  std::memcpy(snapshot.data(), &header, sizeof header);
  return {};
}

Status ProxySet::Impl::Restore(std::span<const std::byte> snapshot) {
  Status wrong = CheckHeader(snapshot, options_);
  if (!wrong.ok()) return wrong;
  Header header;
  std::memcpy(&header, snapshot.data(), sizeof header);
  SnapshotReader reader(snapshot.first(header.bytes).subspan(sizeof header));
  Visit(*this, reader);
  if (reader.failed() || !reader.at_end()) {
    return {StatusCode::kInternal,
            "the snapshot has a valid checksum but wrong fields: report this bug"};
  }
  moving_.FinishRestore();
  resting_.FinishRestore();
  return {};
}

size_t ProxySet::snapshot_bytes() const { return impl_->snapshot_bytes(); }
Status ProxySet::Save(std::span<std::byte> snapshot) const { return impl_->Save(snapshot); }
Status ProxySet::Restore(std::span<const std::byte> snapshot) {
  const FloatEnvironmentScope environment;
  return impl_->Restore(snapshot);
}

}  // namespace sweepstake
