// The command line of thixo-check, printed by the driver and parsed by the program.
#pragma once

#include <string>
#include <vector>

#include "pipeline/contract/argument_words.h"

namespace thixo {

/// What --max-rel-mse may be [1].
inline constexpr NumberRange kRelMse{0, 1e6};

/// thixo-check: compares A with a reference.
struct CheckArgs {
    std::string path;        // A: a frame folder, a cache (output folder or its cache/), or one picture
    std::string against;     // the reference, of the same sort
    std::string frames;      // frame range as written; empty: all
    double max_rel_mse = 0;  // pictures: largest relMSE of a channel that still passes; 0: equal bit for bit
    std::string diff;        // folder for a picture of every difference; empty: none
    int threads = 0;         // 0: all cores
    bool update = false;     // make A the reference
    bool json = false;       // report as one JSON document
    bool quiet = false;      // no text report
    std::string help;        // not empty: --help was given; print this text and exit with 0

    std::vector<std::string> print() const;
    /// Throws InputError.
    static CheckArgs parse(const std::vector<std::string>& args);
};

}  // namespace thixo
