// The queries of ProxySet: checks of their arguments, and the refit of the trees before a query.
#include <cassert>
#include <string>

#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/broad_phase/proxies/proxy_queries.h"
#include "engine_client/broad_phase/proxies/proxy_set_impl.h"
#include "engine_client/broad_phase/proxies/query_shapes.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {
namespace {

Status Check(const Ray& ray) {
  if (!IsFinite(SlabsOf(ray))) {
    return {StatusCode::kInvalidArgument,
            "the ray's origin, direction and max_distance must be finite"};
  }
  if (ray.max_distance < 0) {
    return {StatusCode::kInvalidArgument, "the ray's max_distance must not be negative"};
  }
  return {};
}

Status Check(const BoxSweep& sweep) {
  if (IsValid(sweep.box) && IsFinite(SlabsOf(sweep))) return {};
  return {StatusCode::kInvalidArgument,
          "the swept box must be valid (finite, min <= max), and its translation finite"};
}

Status Check(const Sphere& sphere) {
  bool right = sphere.radius >= 0 && sphere.radius <= Sphere::kMaxRadius;
  for (const float coordinate : sphere.center) right = right && std::isfinite(coordinate);
  if (right) return {};
  return {StatusCode::kInvalidArgument,
          "the sphere's center must be finite, and its radius from 0 to 1e19"};
}

// An invalid box is allowed: a query with it finds nothing.
Status Check(const Aabb&) { return {}; }

// Checks all shapes before the first query, so that an error leaves the results unchanged.
template <typename Shape>
Status CheckAll(const char* name, std::span<const Shape> shapes) {
  for (size_t k = 0; k < shapes.size(); ++k) {
    const Status wrong = Check(shapes[k]);
    if (wrong.ok()) continue;
    return {wrong.code(), name + (" " + std::to_string(k)) + ": " + wrong.message()};
  }
  return {};
}

}  // namespace

template <typename Shape, typename Question>
Status ProxySet::Impl::Ask(const Shape& shape, const Question& question) const {
  Status wrong = Check(shape);
  if (!wrong.ok()) return wrong;
  if (!moving_.trees_are_fresh() || !resting_.trees_are_fresh()) {
    return {StatusCode::kFailedPrecondition,
            "proxies have changed: call PrepareQueries before const queries"};
  }
  question(ProxyQueries(moving_, resting_));
  return {};
}

template <typename Shape>
Status ProxySet::Impl::FindNearestHits(const char* name, std::span<const Shape> shapes,
                                       const CollisionFilter& filter,
                                       std::span<RayHit> hits) const {
  assert(shapes.size() == hits.size());
  Status wrong = CheckAll(name, shapes);
  if (!wrong.ok()) return wrong;
  return Ask(Aabb{}, [&](const ProxyQueries& queries) {
    for (size_t k = 0; k < shapes.size(); ++k) {
      hits[k] = queries.FindNearestHit(SlabsOf(shapes[k]), filter);
    }
  });
}

template <typename Shape, typename Search>
Status ProxySet::Impl::FindMany(std::span<const Shape> shapes, std::span<ProxyHandle> out,
                                std::span<size_t> ends, const Search& search) const {
  assert(shapes.size() == ends.size());
  return Ask(Aabb{}, [&](const ProxyQueries& queries) {
    size_t end = 0;
    for (size_t k = 0; k < shapes.size(); ++k) {
      Found found(out.subspan(end < out.size() ? end : out.size()));
      search(queries, shapes[k], found);
      ends[k] = end += found.count();
    }
  });
}

template <typename Shape, typename Question>
Status ProxySet::Impl::RefreshAndAsk(const Shape& shape, const Question& question) {
  RefreshTrees();
  return Ask(shape, question);
}

void ProxySet::QueryBox(const Aabb& box, const CollisionFilter& filter,
                        std::vector<ProxyHandle>& out) {
  const FloatEnvironmentScope environment;
  impl_->RefreshTrees();
  Found found(out);
  ProxyQueries(impl_->moving_, impl_->resting_).FindInBox(box, filter, found);
}

Status ProxySet::QueryBox(const Aabb& box, const CollisionFilter& filter,
                          std::span<ProxyHandle> out, size_t& count) const {
  const FloatEnvironmentScope environment;
  return std::as_const(*impl_).Ask(box, [&](const ProxyQueries& queries) {
    Found found(out);
    queries.FindInBox(box, filter, found);
    count = found.count();
  });
}

Status ProxySet::QuerySphere(const Sphere& sphere, const CollisionFilter& filter,
                             std::vector<ProxyHandle>& out) {
  const FloatEnvironmentScope environment;
  return impl_->RefreshAndAsk(sphere, [&](const ProxyQueries& queries) {
    Found found(out);
    queries.FindInSphere(sphere, filter, found);
  });
}

Status ProxySet::QuerySphere(const Sphere& sphere, const CollisionFilter& filter,
                             std::span<ProxyHandle> out, size_t& count) const {
  const FloatEnvironmentScope environment;
  return std::as_const(*impl_).Ask(sphere, [&](const ProxyQueries& queries) {
    Found found(out);
    queries.FindInSphere(sphere, filter, found);
    count = found.count();
  });
}

Status ProxySet::CastRay(const Ray& ray, const CollisionFilter& filter, std::vector<RayHit>& hits) {
  const FloatEnvironmentScope environment;
  return impl_->RefreshAndAsk(ray, [&](const ProxyQueries& queries) {
    Found found(hits);
    queries.FindHits(SlabsOf(ray), filter, found);
  });
}

Status ProxySet::CastRay(const Ray& ray, const CollisionFilter& filter, std::span<RayHit> hits,
                         size_t& count) const {
  const FloatEnvironmentScope environment;
  return std::as_const(*impl_).Ask(ray, [&](const ProxyQueries& queries) {
    Found found(hits);
    queries.FindHits(SlabsOf(ray), filter, found);
    count = found.count();
  });
}

Status ProxySet::SweepBox(const BoxSweep& sweep, const CollisionFilter& filter,
                          std::vector<RayHit>& hits) {
  const FloatEnvironmentScope environment;
  return impl_->RefreshAndAsk(sweep, [&](const ProxyQueries& queries) {
    Found found(hits);
    queries.FindHits(SlabsOf(sweep), filter, found);
  });
}

Status ProxySet::SweepBox(const BoxSweep& sweep, const CollisionFilter& filter,
                          std::span<RayHit> hits, size_t& count) const {
  const FloatEnvironmentScope environment;
  return std::as_const(*impl_).Ask(sweep, [&](const ProxyQueries& queries) {
    Found found(hits);
    queries.FindHits(SlabsOf(sweep), filter, found);
    count = found.count();
  });
}

Status ProxySet::CastRayNearest(const Ray& ray, const CollisionFilter& filter, RayHit& hit) {
  const FloatEnvironmentScope environment;
  impl_->RefreshTrees();
  return std::as_const(*this).CastRayNearest(ray, filter, hit);
}

Status ProxySet::CastRayNearest(const Ray& ray, const CollisionFilter& filter, RayHit& hit) const {
  const FloatEnvironmentScope environment;
  return std::as_const(*impl_).Ask(ray, [&](const ProxyQueries& queries) {
    hit = queries.FindNearestHit(SlabsOf(ray), filter);
  });
}

Status ProxySet::SweepBoxNearest(const BoxSweep& sweep, const CollisionFilter& filter,
                                 RayHit& hit) {
  const FloatEnvironmentScope environment;
  impl_->RefreshTrees();
  return std::as_const(*this).SweepBoxNearest(sweep, filter, hit);
}

Status ProxySet::SweepBoxNearest(const BoxSweep& sweep, const CollisionFilter& filter,
                                 RayHit& hit) const {
  const FloatEnvironmentScope environment;
  return std::as_const(*impl_).Ask(sweep, [&](const ProxyQueries& queries) {
    hit = queries.FindNearestHit(SlabsOf(sweep), filter);
  });
}

Status ProxySet::CastRays(std::span<const Ray> rays, const CollisionFilter& filter,
                          std::span<RayHit> hits) const {
  const FloatEnvironmentScope environment;
  return std::as_const(*impl_).FindNearestHits("ray", rays, filter, hits);
}

Status ProxySet::SweepBoxes(std::span<const BoxSweep> sweeps, const CollisionFilter& filter,
                            std::span<RayHit> hits) const {
  const FloatEnvironmentScope environment;
  return std::as_const(*impl_).FindNearestHits("sweep", sweeps, filter, hits);
}

Status ProxySet::QueryBoxes(std::span<const Aabb> boxes, const CollisionFilter& filter,
                            std::span<ProxyHandle> out, std::span<size_t> ends) const {
  const FloatEnvironmentScope environment;
  return std::as_const(*impl_).FindMany(
      boxes, out, ends, [&](const ProxyQueries& queries, const Aabb& box, auto& found) {
        queries.FindInBox(box, filter, found);
      });
}

Status ProxySet::QuerySpheres(std::span<const Sphere> spheres, const CollisionFilter& filter,
                              std::span<ProxyHandle> out, std::span<size_t> ends) const {
  const FloatEnvironmentScope environment;
  Status wrong = CheckAll("sphere", spheres);
  if (!wrong.ok()) return wrong;
  return std::as_const(*impl_).FindMany(
      spheres, out, ends, [&](const ProxyQueries& queries, const Sphere& sphere, auto& found) {
        queries.FindInSphere(sphere, filter, found);
      });
}

}  // namespace sweepstake
