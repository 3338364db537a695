// What the user typed, and the verbs that do it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace thixo {

struct Command {
    std::string verb;
    std::string path;  // SCENE, CACHE, or what the verb takes
    // common
    std::string frames, out;
    std::vector<std::string> set;
    int threads = 0;
    std::optional<std::uint64_t> seed;
    bool draft = false, quiet = false, json = false, dry_run = false, restart = false;
    // of some verbs
    std::string look;                         // run, render
    std::string crop;                         // render
    double fps = 0;                           // film; 0: the scene's
    std::string codec = "h264";               // film
    std::string what, attribute;              // preview, export
    std::string to;                           // export
    std::string against, diff;                // check
    double max_rel_mse = 0;                   // check
    double max_flip = 0, max_flicker = 0;     // check
    std::string tier = "exact", junit, html;  // check
    bool update = false;                      // check
    bool print = false;                       // validate
    bool repair = false;                      // verify
    bool verify = false;                      // run
    bool strict = false;                      // run, sim, validate
    std::string text;                         // not empty: help or version; print this and exit with 0
};

/// Throws InputError, one line, where the words are no command.
Command parse_command(int argc, char** argv);

// Each returns the exit code of what it did, and throws Error where it could not be done.
int run_verb(const Command& command);
int sim_verb(const Command& command);
int render_verb(const Command& command);
int relight_verb(const Command& command);
int film_verb(const Command& command);
int preview_verb(const Command& command);
int check_verb(const Command& command);
int validate_verb(const Command& command);
int info_verb(const Command& command);
int export_verb(const Command& command);
int verify_verb(const Command& command);

}  // namespace thixo
