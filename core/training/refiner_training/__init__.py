"""Makes the weights of the refiner, the small network that corrects the box of the robust tracker.

In the order in which data goes through it: recordings, tracked, clips, crops, pairs and cutouts, samples, fit (network), weights, integers, report.
"""
