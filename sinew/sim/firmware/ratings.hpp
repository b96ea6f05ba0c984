#pragma once
#include "sinew/family/nuri/models.hpp"
#include "sinew/family/rmd/models.hpp"
#include "sinew/family/sam/models.hpp"
#include "sinew/sim/plant/plant.hpp"

/// What the plant of a device is made of: the ratings that a document prints, the rest from `family/assumed.hpp`.
namespace sinew::sim {

Rating rating_of(const sam::Spec& spec);
Rating rating_of(const nuri::Spec& spec);
Rating rating_of(const rmd::Spec& spec);

} // namespace sinew::sim
