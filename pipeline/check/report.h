// What a check found, and how it is told to a person and to a program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace thixo {

/// How far two pictures of one size are apart; A - B over all channels that both have. Pixels with a value that is not
/// finite count as different where their bits differ, and enter no mean.
struct PictureDifference {
    std::size_t pixels_different = 0;  // with at least one channel whose bits differ
    double max_abs = 0;
    int worst_x = -1,
        worst_y = -1;  // where max_abs is, from the top left; the first different pixel where max_abs is 0; -1: none
    std::string worst_channel;
    double rel_mse = 0;  // largest of the channels': mean of (a - b)^2/(b^2 + 0.01)
    double psnr =
        std::numeric_limits<double>::infinity();     // dB, smallest of the channels': 10 log10(max(1, max |b|)^2/MSE)
    std::size_t not_finite_a = 0, not_finite_b = 0;  // values
};

/// How far an attribute of two point sets is apart, point by point in the order of their ids.
struct AttributeDifference {
    std::string name;            // particles.P, surfels.N, ...
    std::size_t different = 0;   // points whose bits differ
    double max_abs = 0;          // over components
    std::int64_t worst_id = -1;  // the point where max_abs is; its place where the points have no ids
};

/// One frame (or file) of A against its partner of the same name.
struct FrameReport {
    std::string name;
    std::vector<std::string> problems;  // each makes the frame fail
    bool damaged = false;               // one of the two could not be read
    bool has_picture = false;
    PictureDifference picture;
    std::vector<AttributeDifference> attributes;  // those that differ
    bool same() const { return problems.empty(); }
};

struct Update {
    std::vector<std::string> added, replaced, removed;
};

struct CheckReport {
    std::string a, b;
    std::string kind;        // pictures, cache
    double max_rel_mse = 0;  // 0: exact
    std::vector<FrameReport> frames;
    std::vector<std::string> notes;  // differences of two manifests that do not make the check fail
    bool updated = false;
    Update update;

    bool same() const;
    bool damaged() const;
};

/// Lines for a person: each failing frame with its numbers, each note, and a last one that sums up.
std::string print_text(const CheckReport& report);

/// One JSON document: {"a", "b", "kind", "tier": "exact" or "rel_mse", "max_rel_mse", "same", "damaged", "frames":
/// [{"name", "same", "damaged", "problems", and for pictures "pixels_different", "max_abs", "rel_mse", "psnr" (null:
/// infinite), "worst": {"x", "y", "channel"}, "not_finite": [a, b], for caches "attributes": [{"name", "different",
/// "max_abs", "worst_id"}]}], "notes": [text], "updated": {"added", "replaced", "removed"} after an update}, ending in
/// a newline.
std::string print_json(const CheckReport& report);

}  // namespace thixo
