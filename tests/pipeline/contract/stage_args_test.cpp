#include "pipeline/contract/stage_args.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/contract/check_args.h"

namespace thixo {
namespace {

// Values a user may give; words of a command line are never joined or split on the way to a stage.
const std::vector<std::string> kTexts = {
    "plain",   "with blank", " a",    "a=b",        "look.camera.position=[1, 2, 3]",
    "-dash",   "--out=x",    "[1,2]", "\"quoted\"", "it's",
    "ünï",     "%%",         "a,b",   "{x: 1}",     "--",
    "$HOME *", "a\nb",       "line\\"};

void expect_same(const CommonArgs& a, const CommonArgs& b) {
    EXPECT_EQ(a.out, b.out);
    EXPECT_EQ(a.frames, b.frames);
    EXPECT_EQ(a.set, b.set);
    EXPECT_EQ(a.threads, b.threads);
    EXPECT_EQ(a.seed, b.seed);
    EXPECT_EQ(a.draft, b.draft);
    EXPECT_EQ(a.quiet, b.quiet);
    EXPECT_EQ(a.machine_progress, b.machine_progress);
    EXPECT_EQ(b.help, "");
}

void fill(CommonArgs& a, std::size_t k) {
    a.out = kTexts[k];
    a.frames = k % 2 ? "1-100x2" : "";
    for (std::size_t i = 0; i < k % 4; ++i) a.set.push_back(kTexts[(k + i) % kTexts.size()]);
    a.threads = static_cast<int>(k % 3);
    if (k % 3 == 1) a.seed = ~std::uint64_t{0} - k;
    if (k % 3 == 2) a.seed = 0;
    a.draft = k & 1;
    a.quiet = k & 2;
    a.machine_progress = k & 4;
}

TEST(StageArgs, SimArgumentsSurvivePrintAndParse) {
    for (std::size_t k = 0; k < kTexts.size(); ++k) {
        SimArgs a;
        fill(a, k);
        a.scene = kTexts[(k + 5) % kTexts.size()];
        a.restart = k & 1;
        a.estimate = k & 2;
        a.initial = k & 8;
        const SimArgs b = SimArgs::parse(a.print());
        SCOPED_TRACE(kTexts[k]);
        expect_same(a, b);
        EXPECT_EQ(a.scene, b.scene);
        EXPECT_EQ(a.restart, b.restart);
        EXPECT_EQ(a.estimate, b.estimate);
        EXPECT_EQ(a.initial, b.initial);
    }
}

TEST(StageArgs, RenderArgumentsSurvivePrintAndParse) {
    for (std::size_t k = 0; k < kTexts.size(); ++k) {
        RenderArgs a;
        fill(a, k);
        if (k % 3) a.scene = kTexts[(k + 7) % kTexts.size()];
        a.look = kTexts[(k + 3) % kTexts.size()];
        a.attribute = k % 2 ? kTexts[k] : "";
        a.what = k % 3 == 0 ? "particles" : k % 3 == 1 ? "surfels" : "auto";
        a.follow = k & 1;
        a.restart = k & 2;
        a.preview = k & 4;
        const RenderArgs b = RenderArgs::parse(a.print());
        SCOPED_TRACE(kTexts[k]);
        expect_same(a, b);
        EXPECT_EQ(a.scene, b.scene);
        EXPECT_EQ(a.look, b.look);
        EXPECT_EQ(a.attribute, b.attribute);
        EXPECT_EQ(a.what, b.what);
        EXPECT_EQ(a.follow, b.follow);
        EXPECT_EQ(a.restart, b.restart);
        EXPECT_EQ(a.preview, b.preview);
    }
}

TEST(StageArgs, OptionAndValueMayBeTwoWords) {
    const SimArgs a = SimArgs::parse({"--set", "a.b=1", "--set", "c=2", "scene.yaml", "--out", "there", "--seed", "7"});
    EXPECT_EQ(a.set, (std::vector<std::string>{"a.b=1", "c=2"}));
    EXPECT_EQ(a.scene, "scene.yaml");
    EXPECT_EQ(a.out, "there");
    EXPECT_EQ(a.seed, 7u);
}

TEST(StageArgs, HelpListsTheArgumentsAndNeedsNoScene) {
    EXPECT_NE(SimArgs::parse({"--help"}).help.find("--restart"), std::string::npos);
    EXPECT_NE(RenderArgs::parse({"-h"}).help.find("--look"), std::string::npos);
}

TEST(StageArgs, BadWordsAreInputErrors) {
    EXPECT_THROW(SimArgs::parse({}), InputError);
    EXPECT_THROW(SimArgs::parse({"--out=x"}), InputError);
    EXPECT_THROW(SimArgs::parse({"scene"}), InputError);
    EXPECT_THROW(SimArgs::parse({"scene", "--out=x", "--frmaes=1"}), InputError);
    EXPECT_THROW(SimArgs::parse({"scene", "--out=x", "--threads=-1"}), InputError);
    EXPECT_THROW(SimArgs::parse({"scene", "--out=x", "--threads=many"}), InputError);
    EXPECT_THROW(SimArgs::parse({"scene", "--out=x", "--seed=-1"}), InputError);
    EXPECT_THROW(SimArgs::parse({"scene", "second", "--out=x"}), InputError);
    EXPECT_THROW(SimArgs::parse({"scene", "--out=x", "--set"}), InputError);
    EXPECT_THROW(RenderArgs::parse({"--out=x", "--what=voxels"}), InputError);
}

TEST(StageArgs, AComparisonTakesNoNumberThatIsNone) {
    for (const char* word : {"nan", "inf", "-1", "1e7", "x"})
        EXPECT_THROW(CheckArgs::parse({"a", "--against=b", std::string("--max-rel-mse=") + word}), InputError) << word;
    EXPECT_EQ(CheckArgs::parse({"a", "--against=b", "--max-rel-mse=0.25"}).max_rel_mse, 0.25);
}

TEST(FrameRange, GivesAscendingFramesWithoutDuplicates) {
    using Frames = std::vector<int>;
    EXPECT_EQ(parse_frame_range("7"), (Frames{7}));
    EXPECT_EQ(parse_frame_range("1-4"), (Frames{1, 2, 3, 4}));
    EXPECT_EQ(parse_frame_range("1-10x4"), (Frames{1, 5, 9}));
    EXPECT_EQ(parse_frame_range("9,1,3-5,4-6x2"), (Frames{1, 3, 4, 5, 6, 9}));
    EXPECT_EQ(parse_frame_range("0-0"), (Frames{0}));
    EXPECT_EQ(parse_frame_range("1-999999").size(), 999999u);
}

TEST(FrameRange, NamesWhatIsWrong) {
    const std::pair<const char*, const char*> cases[] = {
        {"", "is no frame number"},         {"a", "'a' is no frame number"},  {"1,", "is no frame number"},
        {"1-", "is no frame number"},       {"-5", "is no frame number"},     {"1--3", "is no frame number"},
        {"5-1", "ends before it starts"},   {"1-9x0", "has a step of 0"},     {"3x2", "has a step but no range"},
        {"1-9x", "is no frame number"},     {"1-9xx2", "is no frame number"}, {"1000000", "is above 999999"},
        {"99999999999999", "is above"},     {"1 - 3", "is no frame number"},  {"1.5", "is no frame number"},
        {"0x10", "has a step but no range"}};
    for (const auto& [text, why] : cases) {
        try {
            parse_frame_range(text);
            ADD_FAILURE() << "accepted '" << text << "'";
        } catch (const InputError& e) {
            EXPECT_NE(std::string(e.what()).find(why), std::string::npos) << e.what();
        }
    }
}

}  // namespace
}  // namespace thixo
