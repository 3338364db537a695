// The command line of thixo-check, printed by the driver and parsed by the program.
#pragma once

#include <string>
#include <vector>

#include "pipeline/contract/argument_words.h"

namespace thixo {

/// What --max-rel-mse and --max-flicker may be [1], and --max-flip.
inline constexpr NumberRange kRelMse{0, 1e6};
inline constexpr NumberRange kFlip{0, 1};

/// How pictures are compared. `exact`: every bit. `passes`: the bits of the passes that carry no noise of light. `noise`:
/// colours, by tests against the noise that the variance pass tells.
inline const std::vector<std::string> kCheckTiers{"exact", "passes", "noise"};

/// thixo-check: compares A with a reference.
struct CheckArgs {
    std::string path;            // A: a frame folder, a cache (output folder or its cache/), or one picture
    std::string against;         // the reference, of the same sort
    std::string frames;          // frame range as written; empty: all
    double max_rel_mse = 0;      // pictures: largest relMSE of a channel that still passes; 0: equal bit for bit
    std::string tier = "exact";  // pictures: one of kCheckTiers
    double max_flip = 0, max_flicker = 0;  // pictures: largest mean FLIP, largest flicker; 0: no limit
    std::string junit, html;               // file and folder of these reports; empty: none
    std::string diff;                      // folder for a picture of every difference; empty: none
    int threads = 0;                       // 0: all cores
    bool update = false;                   // make A the reference
    bool json = false;                     // report as one JSON document
    bool quiet = false;                    // no text report
    std::string help;                      // not empty: --help was given; print this text and exit with 0

    std::vector<std::string> print() const;
    /// Throws InputError.
    static CheckArgs parse(const std::vector<std::string>& args);
};

}  // namespace thixo
