// What a check found, and its two forms: text for a person, JSON for a program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace thixo {

/// The difference A - B of two pictures of one size, over all channels that both have. Pixels with a value that is not
/// finite count as different where their bits differ. They enter no mean.
struct PictureDifference {
    std::size_t pixels_different = 0;  // with at least one channel whose bits differ
    double max_abs = 0;
    // The pixel of max_abs, counted from the top left. Where max_abs is 0 it is the first pixel that differs; -1: none.
    int worst_x = -1, worst_y = -1;
    std::string worst_channel;
    // Largest of the channels' relMSE:
    //     mean of (a - b)^2/(b^2 + 0.01)
    double rel_mse = 0;
    // Smallest of the channels' peak signal-to-noise ratios [dB]:
    //     10 log10(max(1, max |b|)^2/MSE)
    double psnr = std::numeric_limits<double>::infinity();
    std::size_t not_finite_a = 0, not_finite_b = 0;  // values
};

/// What tests against noise say of two pictures (compare_noisy.h).
struct NoiseDifference {
    std::size_t tests = 0, failed = 0;
    double least_probable = 1;  // the smallest probability of all tests
};

/// How a picture looks beside its partner, and how the sequence goes on.
struct PictureMeasures {
    double flip = 0;        // mean FLIP (flip.h)
    double brightness = 1;  // mean of R + G + B of A over that of B; 1 where both are black
    // How much of the change since the frame before is not in B, over R, G, B; below 0: there is no frame before.
    //     mean of ((a - a0) - (b - b0))^2/(b^2 + 0.01)
    double flicker = -1;
};

/// The difference of one attribute of two point sets, whose points are paired by their ids.
struct AttributeDifference {
    std::string name;            // particles.P, surfels.N, ...
    std::size_t different = 0;   // points whose bits differ
    double max_abs = 0;          // over components
    std::int64_t worst_id = -1;  // id of the point of max_abs; where points have no ids, its place in the order
};

/// One frame (or file) of A against its partner of the same name.
struct FrameReport {
    std::string name;
    std::vector<std::string> problems;  // each makes the frame fail
    bool damaged = false;               // one of the two could not be read
    bool has_picture = false;
    PictureDifference picture;
    std::optional<NoiseDifference> noise;         // of the tier `noise`
    std::optional<PictureMeasures> measures;      // where both have R, G, B
    std::string sheet_picture;                    // file name in the HTML sheet's folder; empty: none
    std::vector<AttributeDifference> attributes;  // those that differ
    bool same() const { return problems.empty(); }
};

struct Update {
    std::vector<std::string> added, replaced, removed;
};

struct CheckReport {
    std::string a, b;
    std::string kind;        // pictures; cache: of output folders, their pictures too
    std::string tier;        // exact, rel_mse, passes, noise
    double max_rel_mse = 0;  // of rel_mse
    std::vector<FrameReport> frames;
    std::vector<std::string> notes;  // differences of two manifests that do not make the check fail
    bool updated = false;
    Update update;

    bool same() const;
    bool damaged() const;
    /// The frame of the largest flicker; null where no frame has any.
    const FrameReport* most_flicker() const;
};

/// "3 pictures agree bit for bit": the last line of print_text.
std::string summary(const CheckReport& report);

/// Lines for a person: each failing frame with its numbers, each note, and a last one that sums up.
std::string print_text(const CheckReport& report);

/// One JSON document that ends in a newline. Keys in brackets are there for pictures (p), caches (c) or after an update
/// (u) alone. A psnr of null is infinite.
///     {"a", "b", "kind", "tier": "exact", "rel_mse", "passes" or "noise", "max_rel_mse", "same", "damaged",
///      "frames": [{"name", "same", "damaged", "problems": [text],
///                  (p) "pixels_different", "max_abs", "rel_mse", "psnr", "worst": {"x", "y", "channel"},
///                      "not_finite": [in a, in b], "flip", "brightness", "flicker" (null without a frame before),
///                      "noise": {"tests", "failed", "least_probable"} (tier noise),
///                  (c) "attributes": [{"name", "different", "max_abs", "worst_id"}]}],
///      "notes": [text],
///      (u) "updated": {"added": [name], "replaced": [name], "removed": [name]}}
std::string print_json(const CheckReport& report);

}  // namespace thixo
