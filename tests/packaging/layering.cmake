# Who may include and link whom (docs: dependencies point one way).
#   cmake -DSOURCE_DIR=<repository> [-DLINKS_FILE=<file>] -P layering.cmake
# Every #include of a layer has to be allowed: <...> by pattern, "..." by being found below the
# layer's roots or beside the including file. LINKS_FILE has lines "target:library;library".
cmake_minimum_required(VERSION 3.16)

set(violations "")
set(checked 0)
set(std "[a-z_0-9]+|c[a-z]+") # headers of the standard library have neither slash nor suffix
set(eigen "(unsupported/)?Eigen/[A-Za-z/]+")

# layer(<name> FOLDERS <where the sources are> ROOTS <where "..." may lie> ANGLE <regex of <...>>)
function(layer name)
  cmake_parse_arguments(ARG "" "ANGLE" "FOLDERS;ROOTS" ${ARGN})
  foreach(folder IN LISTS ARG_FOLDERS)
    file(GLOB_RECURSE files ${SOURCE_DIR}/${folder}/*.h ${SOURCE_DIR}/${folder}/*.cc)
    foreach(file IN LISTS files)
      get_filename_component(beside ${file} DIRECTORY)
      file(RELATIVE_PATH shown ${SOURCE_DIR} ${file})
      file(STRINGS ${file} includes REGEX "^[ \t]*#[ \t]*include")
      math(EXPR checked "${checked} + 1")
      foreach(line IN LISTS includes)
        set(allowed FALSE)
        if(line MATCHES "include[ \t]*<([^>]+)>")
          set(header ${CMAKE_MATCH_1})
          if(header MATCHES "^(${ARG_ANGLE})$")
            set(allowed TRUE)
          endif()
        elseif(line MATCHES "include[ \t]*\"([^\"]+)\"")
          set(header ${CMAKE_MATCH_1})
          foreach(root IN LISTS ARG_ROOTS)
            if(EXISTS ${SOURCE_DIR}/${root}/${header})
              set(allowed TRUE)
            endif()
          endforeach()
          # A path with ".." could lead anywhere.
          if(EXISTS ${beside}/${header} AND NOT header MATCHES "\\.\\.")
            set(allowed TRUE)
          endif()
        else()
          set(header ${line})
        endif()
        if(NOT allowed)
          string(APPEND violations "  ${shown}: the layer ${name} must not include ${header}\n")
        endif()
      endforeach()
    endforeach()
  endforeach()
  set(violations "${violations}" PARENT_SCOPE)
  set(checked ${checked} PARENT_SCOPE)
endfunction()

# The order inside the core. core_module(<folder of slim_init/src> <modules it may include>): every
# "..." of the module is a public header below the method, its own, or one of a named module.
set(core_modules "")
function(core_module name)
  set(core_modules ${core_modules} ${name} PARENT_SCOPE)
  string(REPLACE ";" "|" below "${name};${ARGN}")
  file(GLOB_RECURSE files ${SOURCE_DIR}/slim_init/src/${name}/*.h ${SOURCE_DIR}/slim_init/src/${name}/*.cc)
  foreach(file IN LISTS files)
    file(RELATIVE_PATH shown ${SOURCE_DIR} ${file})
    file(STRINGS ${file} includes REGEX "^[ \t]*#[ \t]*include[ \t]*\"")
    foreach(line IN LISTS includes)
      string(REGEX REPLACE "^[^\"]*\"([^\"]*)\".*" "\\1" header "${line}")
      if(NOT header MATCHES "^(${below}|slim_init)/[^/]+$" OR header MATCHES "^slim_init/(${on_top})\\.h$")
        string(APPEND violations "  ${shown}: the core module ${name} must not include ${header}\n")
      endif()
    endforeach()
  endforeach()
  set(violations "${violations}" PARENT_SCOPE)
endfunction()
# Public headers of what stands on all modules.
set(on_top "initializer|window_solver")
core_module(geometry)
core_module(data geometry)
core_module(imu geometry data)
core_module(priors geometry data imu)
core_module(lines geometry data imu)
core_module(rotation geometry data imu priors lines)
core_module(shape geometry data imu lines)
core_module(estimation geometry data imu priors lines rotation shape)
core_module(scale geometry data imu priors lines rotation shape estimation)
core_module(verdict geometry data imu priors lines rotation shape estimation scale)
core_module(pipeline geometry data imu priors lines rotation shape estimation scale verdict)
# The one module that holds a solver.
set(on_top "initializer")
core_module(session geometry data imu priors lines rotation shape estimation scale verdict pipeline)
# A new module has to be given its place above.
file(GLOB folders LIST_DIRECTORIES TRUE RELATIVE ${SOURCE_DIR}/slim_init/src ${SOURCE_DIR}/slim_init/src/*)
foreach(folder IN LISTS folders)
  if(IS_DIRECTORY ${SOURCE_DIR}/slim_init/src/${folder} AND NOT folder IN_LIST core_modules)
    string(APPEND violations "  slim_init/src/${folder}: the core module has no place in the order\n")
  endif()
endforeach()
layer("public headers" FOLDERS slim_init/include ROOTS slim_init/include ANGLE "${std}|${eigen}")
layer("slim_init core" FOLDERS slim_init/src
      ROOTS slim_init/include slim_init/src ANGLE "${std}|${eigen}")
# What simulation and evaluation share without knowing each other: headers that need Eigen alone.
layer("reference" FOLDERS slim_init/reference ANGLE "${std}|${eigen}")
layer("simulation" FOLDERS slim_init/simulation
      ROOTS slim_init/include feature_tracker_lines/include slim_init/reference
            slim_init/simulation/include slim_init/simulation/src
      ANGLE "${std}|${eigen}|opencv2/[a-z_0-9/]+\\.hpp|(sys/)?[a-z]+\\.h")
layer("evaluation" FOLDERS slim_init/evaluation/include slim_init/evaluation/src
      ROOTS slim_init/include feature_tracker_lines/include slim_init/reference
            slim_init/evaluation/include slim_init/evaluation/src
            vins_estimator_patch/host_health/include
      ANGLE "${std}|${eigen}|nlohmann/json\\.hpp|opencv2/[a-z_0-9/]+\\.hpp|sys/wait\\.h|unistd\\.h|(rosbag|(geometry|sensor)_msgs)/[A-Za-z_]+\\.h")
# Instruments of this repository, not installed, that look into the core.
layer("back end" FOLDERS slim_init/backend
      ROOTS slim_init/include slim_init/src slim_init/evaluation/include
            slim_init/backend/include slim_init/backend/src slim_init/baselines/src
      ANGLE "${std}|${eigen}|ceres/[a-z_]+\\.h")
layer("config" FOLDERS slim_init/config
      ROOTS slim_init/include feature_tracker_lines/include slim_init/baselines/include
            slim_init/config/include
      ANGLE "${std}|${eigen}|opencv2/(core|imgcodecs)\\.hpp")
# It judges with the solver's own parts.
layer("doctor" FOLDERS slim_init/doctor
      ROOTS slim_init/include slim_init/src feature_tracker_lines/include slim_init/reference
            slim_init/evaluation/include slim_init/doctor/include
            vins_estimator_patch/host_health/include
      ANGLE "${std}|${eigen}|nlohmann/json\\.hpp|opencv2/[a-z_0-9/]+\\.hpp")
layer("baselines" FOLDERS slim_init/baselines
      ROOTS slim_init/include slim_init/src slim_init/baselines/include slim_init/baselines/src
      ANGLE "${std}|${eigen}|ceres/[a-z_]+\\.h|opencv2/[a-z_0-9/]+\\.hpp")
layer("feature_tracker_lines" FOLDERS feature_tracker_lines/include feature_tracker_lines/src
      ROOTS slim_init/include slim_init/src feature_tracker_lines/include feature_tracker_lines/src
      ANGLE "${std}|${eigen}|opencv2/[a-z_0-9/]+\\.hpp")
layer("host_health" FOLDERS vins_estimator_patch/host_health
      ROOTS slim_init/include vins_estimator_patch/host_health/include
            vins_estimator_patch/host_health/src
      ANGLE "${std}|${eigen}")
layer("vins_estimator_patch" FOLDERS vins_estimator_patch/src vins_estimator_patch/include/slim_init/vins_adapter
      ROOTS slim_init/include feature_tracker_lines/include slim_init/baselines/include
            slim_init/config/include vins_estimator_patch/host_health/include
            vins_estimator_patch/include vins_estimator_patch/src
      ANGLE "${std}|${eigen}")
layer("tools" FOLDERS slim_init/tools
      ROOTS slim_init/include slim_init/simulation/include slim_init/evaluation/include
            feature_tracker_lines/include vins_estimator_patch/include slim_init/baselines/include
            slim_init/config/include slim_init/doctor/include slim_init/backend/include slim_init/tools
            slim_init/tools/src slim_init/tools/include
      ANGLE "${std}|${eigen}|(sys/)?[a-z_]+\\.h|(opencv2|nlohmann|boost)/[A-Za-z_0-9/]+\\.h(pp)?")

# For nodes alone, the hosts' and ours.
layer("node headers" FOLDERS vins_estimator_patch/include/slim_init/vins_ros
      ROOTS slim_init/include vins_estimator_patch/include
      ANGLE "${std}|${eigen}|(ros|[a-z]+_msgs)/[A-Za-z_]+\\.h")

# Nothing includes these two.
layer("ros edge" FOLDERS slim_init/ros feature_tracker_lines/ros
      ROOTS slim_init/include feature_tracker_lines/include vins_estimator_patch/include
            vins_estimator_patch/host_health/include
            slim_init/baselines/include slim_init/config/include slim_init/ros/include feature_tracker_lines/ros/include
      ANGLE "${std}|${eigen}|opencv2/[a-z_0-9/]+\\.hpp|(ros|slim_init|[a-z0-9]+_(msgs|srvs))/[A-Za-z_0-9]+\\.h")

set(linked 0)
# may_link(<target> <regex of the allowed libraries>)
function(may_link target allowed)
  foreach(line IN LISTS links)
    if(line MATCHES "^${target}:(.*)$")
      math(EXPR linked "${linked} + 1")
      string(REPLACE "|" ";" libraries "${CMAKE_MATCH_1}")
      foreach(library IN LISTS libraries)
        # What a generator expression wraps is what counts: $<LINK_ONLY:x>, $<BUILD_INTERFACE:x>.
        string(REGEX REPLACE "^(\\$<[A-Z_]+:)+([^>]*)>+$" "\\2" library "${library}")
        if(library AND NOT library MATCHES "-NOTFOUND$|^::@" AND NOT library MATCHES "^(${allowed})$")
          string(APPEND violations "  ${target} must not link ${library}\n")
        endif()
      endforeach()
    endif()
  endforeach()
  set(violations "${violations}" PARENT_SCOPE)
  set(linked ${linked} PARENT_SCOPE)
endfunction()

if(LINKS_FILE)
  file(READ ${LINKS_FILE} links)
  string(REPLACE ";" "|" links "${links}")
  string(REPLACE "\n" ";" links "${links}")
  set(base "Eigen3::Eigen|slim_init(_|::)core")
  set(front "slim_init(_|::)feature_tracker_lines")
  may_link(slim_init_core "Eigen3::Eigen")
  may_link(slim_init_host_health "${base}")
  may_link(slim_init_vins_adapter "${base}|slim_init(_|::)host_health|slim_init(_|::)config|Threads::Threads")
  may_link(slim_init_config
           "${base}|${front}|slim_init(_|::)baselines|SlimInitOpenCV::SlimInitOpenCV")
  may_link(slim_init_doctor
           "${base}|${front}|slim_init(_|::)evaluation|slim_init(_|::)host_health|SlimInitOpenCV::SlimInitOpenCV")
  may_link(slim_init_feature_tracker_lines "${base}|SlimInitOpenCV::SlimInitOpenCV")
  may_link(slim_init_simulation "${base}|${front}")
  may_link(slim_init_rendering
           "${base}|${front}|slim_init(_|::)simulation|SlimInitOpenCV::SlimInitOpenCV")
  may_link(slim_init_evaluation
           "${base}|slim_init(_|::)host_health|${front}|nlohmann_json::nlohmann_json|SlimInitOpenCV::SlimInitOpenCV|SlimInitRosbag::SlimInitRosbag|Threads::Threads")
  may_link(slim_init_backend "${base}|slim_init(_|::)evaluation|Ceres::ceres")
  may_link(slim_init_baselines "${base}")
  may_link(slim_init_ceres_baselines
           "slim_init(_|::)baselines|Ceres::ceres|SlimInitOpenCV::SlimInitOpenCV")
  if(linked EQUAL 0)
    message(FATAL_ERROR "layering: ${LINKS_FILE} names no target of ours")
  endif()
endif()

if(checked EQUAL 0)
  message(FATAL_ERROR "layering: no source file found in ${SOURCE_DIR}")
endif()
if(violations)
  message(FATAL_ERROR "layering: dependencies that point the wrong way\n${violations}")
endif()
message("layering: ${checked} files and ${linked} targets are in order")
