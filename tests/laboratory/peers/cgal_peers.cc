#include "tests/laboratory/peers/peer.h"

#include <CGAL/box_intersection_d.h>
#include <CGAL/version.h>

namespace sweepstake::cli {
namespace {

// The handle points to the box in the caller's array. The index of the box in that array is the id.
using HandledBox =
    CGAL::Box_intersection_d::Box_with_handle_d<float, 3, const Aabb*,
                                                CGAL::Box_intersection_d::ID_FROM_HANDLE>;

class CgalPeer final : public Peer {
 public:
  using Peer::Peer;

  void DoBuild(std::span<const Aabb> boxes) override { DoUpdate(boxes); }

  void DoUpdate(std::span<const Aabb> boxes) override {
    kept_.assign(boxes.begin(), boxes.end());
    boxes_.clear();
    for (const Aabb& box : kept_) {
      float low[3] = {box.min[0], box.min[1], box.min[2]};
      float high[3] = {box.max[0], box.max[1], box.max[2]};
      boxes_.emplace_back(low, high, &box);
    }
  }

  void DoFindPairs(PairBuffer& out) override {
    const Aabb* first = kept_.data();
    CGAL::box_self_intersection_d(boxes_.begin(), boxes_.end(),
                                  [&](const HandledBox& a, const HandledBox& b) {
                                    AppendPair(out, static_cast<uint32_t>(a.handle() - first),
                                               static_cast<uint32_t>(b.handle() - first));
                                  });
  }

 private:
  std::vector<Aabb> kept_;
  std::vector<HandledBox> boxes_;
};

}  // namespace

void AddCgalPeers(PeerLibrary& library) {
  library.version = CGAL_VERSION_STR;
  library.kinds = {{"CgalBoxes", "KDTree", 10'000'000, false, MakePeer<CgalPeer>}};
}

}  // namespace sweepstake::cli
