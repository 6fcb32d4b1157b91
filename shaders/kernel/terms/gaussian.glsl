// A Gaussian window of the distance rho.
float gaussian(float rho, float width) { return exp(-0.5 * rho * rho / (width * width)); }
