// The command line between the driver and the stages: one struct each that prints and parses itself.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace thixo {

/// Frames as users write them: "1-100", "1-100x2", "7", "1,3,5-9". Ascending, no duplicates. Throws InputError.
std::vector<int> parse_frame_range(const std::string& text);

/// Arguments both stages take. parse(print()) gives the same arguments; parse throws InputError where a word is not
/// understood.
struct CommonArgs {
    std::string out;               // output folder, holds cache/, frames/, checkpoint/
    std::string frames;            // frame range as written; empty: all of the scene
    std::vector<std::string> set;  // key.path=value, applied to the scene in order
    int threads = 0;               // 0: all cores
    std::optional<std::uint64_t> seed;
    bool draft = false;
    bool quiet = false;
    bool machine_progress = false;  // "@progress ..." lines for the driver
    std::string help;               // not empty: --help was given; print this text and exit with 0
};

/// thixo-sim: SCENE -> out/cache.
struct SimArgs : CommonArgs {
    std::string scene;
    bool restart = false;   // discard an existing cache
    bool estimate = false;  // print estimated particles, memory, disk as JSON; simulate nothing
    bool initial = false;   // frame `first` only, into `out`; no checkpoint
    std::vector<std::string> print() const;
    static SimArgs parse(const std::vector<std::string>& args);
};

/// A part of a picture, in pixels from the top left.
struct Crop {
    int x = 0, y = 0, width = 0, height = 0;
};
/// "x,y,width,height". Throws InputError where it is not that, or is empty.
Crop parse_crop(const std::string& text);

/// thixo-render: out/cache -> out/frames*.
struct RenderArgs : CommonArgs {
    std::string scene;          // its look replaces the cache's; empty: the look stored in the manifest
    std::string look;           // look file laid over that
    std::string pictures;       // folder for frames*; empty: `out`
    std::string crop;           // as parse_crop takes it; empty: the whole picture
    bool follow = false;        // wait for frames that a running simulation still makes
    bool restart = false;       // replace frames made with another look
    bool relight = false;       // mix the light groups of frames that are there, where that is enough
    bool preview = false;       // OSMesa pictures instead of ray tracing
    std::string what = "auto";  // preview: particles, surfels, auto
    std::string attribute;      // preview: colour by this attribute
    std::vector<std::string> print() const;
    static RenderArgs parse(const std::vector<std::string>& args);
};

}  // namespace thixo
