#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/driver/command.h"

namespace thixo {
namespace {

Command parse(std::vector<std::string> words) {
    words.insert(words.begin(), "thixo");
    std::vector<char*> argv;
    for (std::string& w : words) argv.push_back(w.data());
    return parse_command(static_cast<int>(argv.size()), argv.data());
}

std::string refusal(const std::vector<std::string>& words) {
    try {
        parse(words);
    } catch (const InputError& e) {
        return e.what();
    }
    return {};
}

TEST(CommandLine, TakesTheCommonOptionsOfRun) {
    const Command c =
        parse({"run",         "a b.yaml", "--frames", "1-10x2",    "--set",     "solver.seed=7", "--set",
               "title=a = b", "--out",    "x",        "--threads", "3",         "--seed",        "18446744073709551615",
               "--draft",     "--quiet",  "--json",   "--dry-run", "--restart", "--look",        "l.yaml"});
    EXPECT_EQ("run", c.verb);
    EXPECT_EQ("a b.yaml", c.path);
    EXPECT_EQ("1-10x2", c.frames);
    EXPECT_EQ((std::vector<std::string>{"solver.seed=7", "title=a = b"}), c.set);
    EXPECT_EQ("x", c.out);
    EXPECT_EQ(3, c.threads);
    EXPECT_EQ(18446744073709551615ull, c.seed);
    EXPECT_TRUE(c.draft && c.quiet && c.json && c.dry_run && c.restart);
    EXPECT_EQ("l.yaml", c.look);
}

TEST(CommandLine, OptionsMayStandBeforeThePath) {
    EXPECT_EQ("s.yaml", parse({"sim", "--set", "a=1", "s.yaml"}).path);
    EXPECT_EQ("s.yaml", parse({"sim", "--frames=1-3", "s.yaml"}).path);
}

TEST(CommandLine, AValueMayBeginWithADash) {
    EXPECT_EQ((std::vector<std::string>{"-x=1"}), parse({"sim", "s.yaml", "--set=-x=1"}).set);
}

TEST(CommandLine, TakesTheOwnOptionsOfTheOtherVerbs) {
    EXPECT_EQ("b", parse({"check", "a", "--against", "b", "--update"}).against);
    EXPECT_TRUE(parse({"validate", "s.yaml", "--print"}).print);
    EXPECT_TRUE(parse({"info", "p", "--json"}).json);
    const Command e = parse({"export", "c", "--to", "vtp", "--what", "surfels"});
    EXPECT_EQ("vtp", e.to);
    EXPECT_EQ("surfels", e.what);
    const Command r = parse({"render", "c", "--crop", "0,0,8,8", "--width", "320", "--samples=9", "--seed", "4"});
    EXPECT_EQ("0,0,8,8", r.crop);
    EXPECT_EQ((std::vector<std::string>{"look.output.width=320", "look.output.samples=9"}), r.set);
    EXPECT_EQ(4u, r.seed);
    const Command f = parse({"film", "c", "--fps", "12.5", "--codec", "prores", "--set", "look.output.exposure=1"});
    EXPECT_EQ(12.5, f.fps);
    EXPECT_EQ("prores", f.codec);
    EXPECT_NE("", refusal({"film", "c", "--codec", "mpeg1"}));
    EXPECT_NE("", refusal({"film", "c", "--fps", "-1"}));
    EXPECT_NE("", refusal({"render", "c", "--height", "0"}));
    const Command p = parse({"preview", "c", "--attribute", "density", "--what", "particles"});
    EXPECT_EQ("density", p.attribute);
}

TEST(CommandLine, BadUsageIsOneClearLine) {
    const std::vector<std::vector<std::string>> wrong{{},
                                                      {"simulate", "s.yaml"},
                                                      {"run"},
                                                      {"run", "a.yaml", "b.yaml"},
                                                      {"run", "a.yaml", "--nonsense"},
                                                      {"run", "a.yaml", "--threads", "many"},
                                                      {"run", "a.yaml", "--threads", "-1"},
                                                      {"run", "a.yaml", "--seed", "-1"},
                                                      {"run", "a.yaml", "--seed", "1e3"},
                                                      {"run", "a.yaml", "--frames", "9-1"},
                                                      {"run", "a.yaml", "--set"},
                                                      {"check", "a"},
                                                      {"export", "c"},
                                                      {"export", "c", "--to", "obj"},
                                                      {"info", "p", "--draft"}};
    for (const std::vector<std::string>& words : wrong) {
        const std::string message = refusal(words);
        std::string command;
        for (const std::string& w : words) command += w + " ";
        EXPECT_FALSE(message.empty()) << command;
        EXPECT_EQ(std::string::npos, message.find('\n')) << command << message;
    }
    EXPECT_NE(std::string::npos, refusal({"simulate", "s.yaml"}).find("'simulate'"));
    EXPECT_NE(std::string::npos, refusal({"run", "a.yaml", "--nonsense"}).find("--nonsense"));
}

TEST(CommandLine, EveryNumberOfEveryOptionIsFiniteAndInRange) {
    const std::vector<std::string> check{"check", "a", "--against", "b", "--max-rel-mse"};
    for (const char* word : {"nan", "-nan", "inf", "-inf", "-0.1", "1e7", "1e999", "0x10", "1,5", "1 ", "", "one"}) {
        std::vector<std::string> words = check;
        words.push_back(word);
        EXPECT_NE(std::string::npos, refusal(words).find("--max-rel-mse")) << word << ": " << refusal(words);
    }
    for (const char* word : {"nan", "1.5", "1025", "-1", "1e3", "99999999999999999999"}) {
        EXPECT_NE(std::string::npos, refusal({"run", "a.yaml", "--threads", word}).find("--threads")) << word;
        if (std::string(word) != "1025") {
            EXPECT_NE(std::string::npos, refusal({"run", "a.yaml", "--seed", word}).find("--seed")) << word;
        }
    }
    std::vector<std::string> words = check;
    words.push_back("1e-3");
    EXPECT_EQ(1e-3, parse(words).max_rel_mse);
}

TEST(CommandLine, AnEmptyWordIsRefusedByItsOption) {
    EXPECT_NE(std::string::npos, refusal({"run", "a.yaml", "--out", ""}).find("--out"));
    EXPECT_NE(std::string::npos, refusal({"run", "a.yaml", "--look", ""}).find("--look"));
    EXPECT_FALSE(refusal({"info", ""}).empty());
}

TEST(CommandLine, BytesThatJsonCannotCarryAreRefusedBeforeTheWork) {
    EXPECT_NE(std::string::npos, refusal({"run", "a.yaml", "--out", "\xff", "--json"}).find("UTF-8"));
    EXPECT_NE(std::string::npos, refusal({"export", "b\xc3", "--to", "csv", "--json"}).find("UTF-8"));
    EXPECT_EQ("", refusal({"run", "a.yaml", "--out", "\xff"}));
    EXPECT_EQ("", refusal({"run", "a.yaml", "--out", "\xc3\xa4\xe2\x82\xac\xf0\x9f\x8c\x8a", "--json"}));
}

TEST(CommandLine, HelpOfAVerbNamesItsOptions) {
    EXPECT_NE(std::string::npos, parse({"--help"}).text.find("run SCENE"));
    EXPECT_NE(std::string::npos, parse({"run", "--help"}).text.find("--frames"));
    EXPECT_NE(std::string::npos, parse({"check", "--help"}).text.find("--against"));
    EXPECT_EQ(0u, parse({"--version"}).text.find("thixo "));
}

}  // namespace
}  // namespace thixo
