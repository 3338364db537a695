#include "pipeline/contract/picture_cost.h"

#include <set>

#include "pipeline/contract/image.h"
#include "pipeline/contract/look_images.h"

namespace thixo::scene {
namespace {

// Bytes a pixel. A picture has 15 float channels (60), an 8-bit copy (4) with its PNG (4), a half of 10 channels (20),
// and its EXR, which grows by doubling (up to 2 x 40).
constexpr double kPicture = 168;
// An EXR of ten half and five float channels, of which noise leaves ZIP little to save beyond a third, and a PNG.
constexpr double kPictureDisk = 30;
// Bytes a pixel of one more float channel: 4, and up to 2 x 4 in the EXR that grows. On disk ZIP saves a quarter; mattes
// are even almost everywhere.
constexpr double kChannel = 12, kChannelDisk = 3, kMatteDisk = 0.4;
// Bytes a pixel and channel stored as half; on disk noise leaves ZIP a little.
constexpr double kHalf = 10, kHalfDisk = 1.8;
// Bytes a pixel that the denoiser adds: 72 floats with their borders, and 36 for each light group.
constexpr double kDenoiser = 350, kDenoiserGroup = 180;
// 8-bit pixels (4) become float colours (12) with smaller copies of them (4); an EXR's are floats (16) at first.
constexpr double kTexture = 20, kEnvironment = 48;

}  // namespace

PictureCost picture_cost(const Look& look, const CacheReader* cache) {
    const double pixels = double(look.output.width) * double(look.output.height);
    PictureCost cost{kPicture * pixels, kPictureDisk * pixels};
    const Passes& passes = look.output.passes;
    const int data = 3 * passes.position + 4 * passes.motion + passes.body, mattes = 24 * passes.cryptomatte;
    cost.memory += kChannel * (data + mattes) * pixels;
    cost.disk_per_frame += (kChannelDisk * data + kMatteDisk * mattes) * pixels;
    std::set<std::string> groups;
    if (passes.lights) groups.insert(kBackgroundGroup);
    for (const Light& l : look.lights)
        if (passes.lights) groups.insert(group_of(l));
    if (passes.lights && glows(look)) groups.insert(kGlowGroup);
    const bool denoise = look.output.denoise;
    const double halves = 3 * (double(denoise) + double(groups.size()));
    cost.memory += (kHalf * halves + denoise * (kDenoiser + kDenoiserGroup * double(groups.size()))) * pixels;
    cost.disk_per_frame += kHalfDisk * halves * pixels;
    std::set<std::string> counted;  // each image is in memory once
    for_each_image(look, [&](const std::string&, ImageUse use, const std::string& file, const std::string& content) {
        if (!counted.insert(content).second) return;
        const std::string bytes = image_bytes(file, content, cache);
        cost.memory +=
            double(bytes.size()) + (use == ImageUse::environment ? kEnvironment : kTexture) * pixels_of(bytes, file);
    });
    return cost;
}

}  // namespace thixo::scene
