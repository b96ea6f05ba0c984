#include "sinew/family/nuri/framing.hpp"
#include "tests/fuzz/framing.hpp"

/// Any bytes as what a Nuri device and its host hear.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    sinew::fuzz::claim_framing({data, size}, [](std::span<const std::uint8_t> bytes, bool silent) {
        return sinew::nuri::protocol().find_request(bytes, silent);
    });
    sinew::fuzz::claim_framing({data, size}, [](std::span<const std::uint8_t> bytes, bool silent) {
        return sinew::nuri::protocol().find_reply(bytes, 0, silent);
    });
    return 0;
}
