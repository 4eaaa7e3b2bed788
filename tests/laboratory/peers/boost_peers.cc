#include "tests/laboratory/peers/peer.h"

#include <boost/function_output_iterator.hpp>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <boost/version.hpp>

namespace sweepstake::cli {
namespace {

namespace bg = boost::geometry;
namespace bgi = boost::geometry::index;

using Point = bg::model::point<float, 3, bg::cs::cartesian>;
using Box = bg::model::box<Point>;
using Entry = std::pair<Box, uint32_t>;
// Nodes of 4 entries are faster than nodes of 8 or 16.
using Tree = bgi::rtree<Entry, bgi::linear<4>>;

Box BoxOf(const Aabb& box) {
  return {{box.min[0], box.min[1], box.min[2]}, {box.max[0], box.max[1], box.max[2]}};
}

// Packs a new tree in each frame, which costs less than moving every object in the old tree.
class RtreePeer final : public Peer {
 public:
  using Peer::Peer;

  void DoBuild(std::span<const Aabb> boxes) override { DoUpdate(boxes); }

  void DoUpdate(std::span<const Aabb> boxes) override {
    entries_.resize(boxes.size());
    for (uint32_t i = 0; i < boxes.size(); ++i) entries_[i] = {BoxOf(boxes[i]), i};
    tree_ = Tree(entries_);
  }

  void DoFindPairs(PairBuffer& out) override {
    for (const Entry& entry : entries_) {
      const uint32_t id = entry.second;
      tree_.query(bgi::intersects(entry.first),
                  boost::make_function_output_iterator([&](const Entry& other) {
                    if (id < other.second) out.Append({id, other.second});
                  }));
    }
  }

 private:
  std::vector<Entry> entries_;
  Tree tree_;
};

}  // namespace

void AddBoostPeers(PeerLibrary& library) {
  library.version =
      std::to_string(BOOST_VERSION / 100'000) + "." + std::to_string(BOOST_VERSION / 100 % 1000);
  library.kinds = {{"BoostRtree", "KDTree", 10'000'000, false, MakePeer<RtreePeer>}};
}

}  // namespace sweepstake::cli
