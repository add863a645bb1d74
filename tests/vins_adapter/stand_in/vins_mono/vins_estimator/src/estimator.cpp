// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The order of calls about a start and a failure, with the lines that the insertions stand beside.
#include "estimator.h"

int ESTIMATE_EXTRINSIC = 0, ESTIMATE_TD = 0;
double TD = 0.0;
std::vector<Matrix3d> RIC(1, Matrix3d::Identity());
std::vector<Vector3d> TIC(1, Vector3d::Zero());

void Estimator::clearState()
{
    clearParts();
}

void Estimator::solveOdometry()
{
    optimization();
}

void Estimator::double2vector()
{
    Matrix3d rot_diff = host_turn;
    for (int i = 0; i <= WINDOW_SIZE; i++)
    {

        Rs[i] = rot_diff * Quaterniond(para_Pose[i][6], para_Pose[i][3], para_Pose[i][4], para_Pose[i][5]).normalized().toRotationMatrix();
    }
}

void Estimator::processImage(const ImageFeatures &image, const std_msgs::Header &header)
{
    ROS_DEBUG("Adding feature points %lu", image.size());
    marginalization_flag = next_flag;
    Headers[frame_count] = header;
    if (solver_flag == INITIAL)
    {
        if (frame_count == WINDOW_SIZE)
        {
            bool result = false;
            if( ESTIMATE_EXTRINSIC != 2 && (header.stamp.toSec() - initial_timestamp) > 0.1)
            {
               result = initialStructure();
               initial_timestamp = header.stamp.toSec();
            }
            if(result)
            {
                solver_flag = NON_LINEAR;
                solveOdometry();
            }
            slideWindow();
        }
        else
            frame_count++;
    }
    else
    {
        solveOdometry();

        if (failureDetection())
        {
            failure_occur = true;
            clearState();
            setParameter();
            return;
        }
        slideWindow();
        last_R = Rs[WINDOW_SIZE];
        last_P = Ps[WINDOW_SIZE];
    }
}
