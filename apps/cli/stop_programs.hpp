#pragma once
#include "apps/cli/stopping.hpp"
#include "sinew/robot/guardian.hpp"

#include <map>
#include <vector>

namespace sinew::cli {

/// A program with a guardian holds its ports, and would go on commanding: it is told first.
class Programs
{
public:
    Programs() : all_(robot::guarded_programs()) {}

    /// Whether one of them has this link.
    bool hold(const std::string& link) const;

    /// What the program that holds this link did to this device, or with -1 to all of them; nothing where none holds
    /// it, or nobody answers for it.
    std::optional<Done> stop_holder(const std::string& name, const std::string& link, int id);

    /// Whether one was told that may not have let go of its port yet.
    bool any_was_told() const { return !told_.empty(); }

private:
    std::vector<robot::Guarded> all_;
    std::map<int, std::expected<robot::StoppedProgram, Error>> told_;
};

/// A program that was told to stop its one device ends, and then the port is free for the others.
void wait_for_port(Session& session, const Programs& programs, const std::string& link);

} // namespace sinew::cli
