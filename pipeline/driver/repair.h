// Makes again what an output folder has lost.
#pragma once

#include "pipeline/driver/command.h"
#include "pipeline/driver/job.h"
#include "pipeline/driver/verify.h"

namespace thixo {

/// Runs the stages that make the damaged files again: the simulation from its nearest checkpoint, the pictures of
/// frames/, the film. A scene is needed where the manifest is damaged or the scene has meshes; else the cache's own is
/// taken. What cannot be made is told as a warning and stays. Pictures are made by the look of those that are whole.
/// Throws as the stages do.
void repair_output(const Command& command, const Job& job, const VerifyReport& report);

}  // namespace thixo
