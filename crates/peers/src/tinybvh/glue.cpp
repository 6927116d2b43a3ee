// tinybvh behind five C functions, for `umbrage-bench peers --tinybvh PATH`. It is compiled by hand, beside the header tiny_bvh.h
// (MIT licence, from github.com/jbikker/tinybvh or the crate tinybvh-rs; 1.6.8 is known to work):
//
//   c++ -std=c++20 -O3 -march=native -shared -fPIC -pthread -I FOLDER_OF_THE_HEADER glue.cpp -o libumbrage_tinybvh.so
#define TINYBVH_IMPLEMENTATION
#include "tiny_bvh.h"
#include <cstddef>

namespace {

constexpr int WIDTH = 16;

/// `RayHitPacket` of packet.rs.
struct Packet {
    float origin[3][WIDTH], t_near[WIDTH], direction[3][WIDTH], time[WIDTH], t_far[WIDTH];
    uint32_t mask[WIDTH], id[WIDTH], flags[WIDTH];
    float normal[3][WIDTH], u[WIDTH], v[WIDTH];
    uint32_t primitive[WIDTH], geometry[WIDTH];
};
static_assert(offsetof(Packet, t_far) == 8 * 64 && offsetof(Packet, geometry) == 18 * 64);

struct Hierarchy {
    virtual ~Hierarchy() = default;
    virtual void build(const tinybvh::bvhvec4slice& corners, const uint32_t* indices, uint32_t triangles) = 0;
    virtual void nearest(tinybvh::Ray& ray) const = 0;
    virtual bool occluded(const tinybvh::Ray& ray) const = 0;
};

template <class Layout> struct With final : Hierarchy {
    Layout bvh;

    void build(const tinybvh::bvhvec4slice& corners, const uint32_t* indices, uint32_t triangles) override {
        if constexpr (std::is_same_v<Layout, tinybvh::BVH>) {
            bvh.BuildAVX(corners, indices, triangles);
        } else {
            bvh.Build(corners, indices, triangles);
        }
    }
    void nearest(tinybvh::Ray& ray) const override { bvh.Intersect(ray); }
    bool occluded(const tinybvh::Ray& ray) const override { return bvh.IsOccluded(ray); }
};

/// Directions keep their lengths, as those of Embree do.
tinybvh::Ray ray_of(const Packet& packet, int lane) {
    const auto vector = [lane](const float (&of)[3][WIDTH]) { return tinybvh::bvhvec3(of[0][lane], of[1][lane], of[2][lane]); };
    tinybvh::Ray ray;
    ray.O = vector(packet.origin);
    ray.D = vector(packet.direction);
    ray.rD = tinybvh::tinybvh_rcp(ray.D);
    ray.hit.t = packet.t_far[lane];
    return ray;
}

}  // namespace

extern "C" {

Hierarchy* umbrage_tinybvh_new(int wide) {
    if (wide) return new With<tinybvh::BVH8_CPU>;
    return new With<tinybvh::BVH>;
}

void umbrage_tinybvh_release(Hierarchy* hierarchy) { delete hierarchy; }

void umbrage_tinybvh_build(
    Hierarchy* hierarchy, const tinybvh::bvhvec4* positions, uint32_t vertices, const uint32_t* indices, uint32_t triangles
) {
    hierarchy->build(tinybvh::bvhvec4slice{positions, vertices}, indices, triangles);
}

void umbrage_tinybvh_nearest(const Hierarchy* hierarchy, const int* valid, Packet* packet) {
    for (int lane = 0; lane < WIDTH; lane++) {
        if (!valid[lane]) continue;
        tinybvh::Ray ray = ray_of(*packet, lane);
        const float far = ray.hit.t = std::min(ray.hit.t, BVH_FAR);
        hierarchy->nearest(ray);
        if (ray.hit.t >= far) continue;
        packet->t_far[lane] = ray.hit.t;
        packet->primitive[lane] = ray.hit.prim;
        packet->geometry[lane] = 0;
    }
}

void umbrage_tinybvh_occluded(const Hierarchy* hierarchy, const int* valid, Packet* packet) {
    for (int lane = 0; lane < WIDTH; lane++) {
        if (valid[lane] && hierarchy->occluded(ray_of(*packet, lane))) packet->t_far[lane] = -1.0f;
    }
}

}
